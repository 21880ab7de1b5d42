from dataclasses import fields
from inspect import signature

import pytest

from unstructured_mg import cli
from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.options import NAMES, ROOMS, BuildOptions, build_options, capture_options

GIVEN = {
    "descriptor": "shape_histogram",
    "rank": 32,
    "windows": "adaptive",
    "window": 4,
    "largest_window": 12,
    "threshold": 0.02,
    "velocity": 0.2,
    "colour": 0.05,
    "cage": "tetwild",
    "hausdorff": 0.05,
    "blend": "linear",
    "weights": "linear",
    "texture": "crossfade",
    "graph": "essential",
    "probabilities": "entropy",
    "visit": ("walk=2", "12..40=0.5"),
}
# What a word needs beside it.
BESIDE = {"largest_window": {"windows": "adaptive"}}


def test_every_word_reaches_its_room_and_nothing_else():
    assert GIVEN.keys() == NAMES.keys()
    for word, value in GIVEN.items():
        room, name = NAMES[word]
        options = build_options(**{word: value}, **BESIDE.get(word, {}))
        assert getattr(getattr(options, room), name) == value != getattr(ROOMS[room](), name)
        for other in set(ROOMS) - {room}:
            assert getattr(options, other) == ROOMS[other]()
    assert build_options(fps=25.0, max_pairs=2) == BuildOptions(fps=25.0, max_pairs=2)
    assert build_options(**dict.fromkeys(GIVEN)) == BuildOptions()


def test_the_command_line_has_no_word_that_is_ignored():
    words = set(signature(cli.build).parameters) - {"capture", "output", "workers", "why", "dask"}
    own = {field.name for field in fields(BuildOptions)} - set(ROOMS)
    assert words <= own | set(NAMES)
    assert set(NAMES) <= words


@pytest.mark.parametrize(("word", "value"), [("cage", "box"), ("blend", "nurbs"), ("weights", ""), ("texture", 3),
                                             ("hausdorff", -1.0), ("threshold", -0.1), ("window", 0),
                                             ("graph", "tree"), ("visit", ("walk",))])  # fmt: skip
def test_a_bad_value_is_called_by_the_command_lines_word(word, value):
    with pytest.raises(UserError, match=f"^--{word}: expected"):
        build_options(**{word: value})


@pytest.mark.parametrize(("word", "metres"), [("dm", 0.1), ("inch", 0.0254), ("0.25", 0.25), (None, None)])
def test_a_unit_is_a_name_or_a_number(word, metres):
    assert capture_options(None, word, None, None)["unit"] == metres


@pytest.mark.parametrize(
    ("given", "option"),
    [
        ((0.0, None, None, None), "--fps"),
        ((None, "furlong", None, None), "--unit"),
        ((None, "0", None, None), "--unit"),
        ((None, "nan", None, None), "--unit"),
        ((None, None, "up", None), "--up"),
        ((None, None, None, float("inf")), "--floor"),
    ],
)
def test_a_refusal_names_the_option(given, option):
    with pytest.raises(UserError, match=f"^{option} is .*; give "):
        capture_options(*given)
