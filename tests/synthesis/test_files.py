import dataclasses
import json

import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.files import read_transition, step_name, write_transition
from unstructured_mg.synthesis.texture_flow import TextureFlow
from unstructured_mg.synthesis.transition import Transition


def transition(**changes):
    rng = np.random.default_rng(0)
    given = {
        "source": 4,
        "target": 90,
        "k": 2,
        "vertices": rng.normal(size=(3, 5, 3)),
        "faces": np.array([[0, 1, 2], [2, 3, 4]], np.int32),
        "uv": rng.uniform(size=(6, 2)),
        "face_uv": np.array([[0, 1, 2], [3, 4, 5]], np.int32),
        "textures": (b"one", b"two", b"three"),
        "texture_suffix": ".jpg",
        "colors": None,
        "alignment": PlanarRigid(0.1, -2.0, 3.0),
        "card": {"start": {"surface": 1.25}, "inverted_tets": None},
        "flow": TextureFlow(
            *(rng.normal(size=shape).astype(np.float32) for shape in ((5, 3), (5, 3), (6, 2))),
            (b"a", b"b"),
            ".jpg",
            None,
        ),
    }
    return Transition(**(given | changes))


def same(first, second):
    for name in ("vertices", "faces", "uv", "face_uv"):
        a, b = getattr(first, name), getattr(second, name)
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    for name in ("source", "target", "k", "textures", "texture_suffix", "alignment", "card", "ends"):
        assert getattr(first, name) == getattr(second, name)
    assert (first.flow is None) == (second.flow is None)
    if first.flow is not None:
        for name in ("reference", "displacement", "uv_flow"):
            a, b = getattr(first.flow, name), getattr(second.flow, name)
            assert a.dtype == b.dtype == np.float32
            np.testing.assert_array_equal(a, b)
        for name in ("textures", "texture_suffix"):
            assert getattr(first.flow, name) == getattr(second.flow, name)


def test_what_is_written_is_read(tmp_path):
    write_transition(transition(), tmp_path / "a")
    same(read_transition(tmp_path / "a"), transition())
    assert (transition().leaves, transition().arrives) == (2, 92)
    warped = transition(ends=(1, 95))
    write_transition(warped, tmp_path / "warped")
    same(read_transition(tmp_path / "warped"), warped)
    assert (warped.leaves, warped.arrives) == (1, 95)
    assert (tmp_path / "a" / "step_-01.jpg").read_bytes() == b"one"
    assert (tmp_path / "a" / "start.jpg").read_bytes() == b"a" and (tmp_path / "a" / "end.jpg").read_bytes() == b"b"
    assert json.loads((tmp_path / "a" / "card.json").read_text()) == transition().card


def test_colours_instead_of_textures(tmp_path):
    colors = np.arange(45, dtype=np.uint8).reshape(3, 5, 3)
    ends = dataclasses.replace(
        transition().flow, uv_flow=np.zeros((0, 2), np.float32), textures=(), texture_suffix="", colors=colors[:2]
    )
    coloured = transition(colors=colors, textures=(), texture_suffix="", flow=ends)
    write_transition(coloured, tmp_path)
    found = read_transition(tmp_path)
    same(found, coloured)
    np.testing.assert_array_equal(found.colors, colors)
    np.testing.assert_array_equal(found.flow.colors, colors[:2])


def test_without_colour_there_is_no_flow(tmp_path):
    bare = transition(textures=(), texture_suffix="", flow=None)
    write_transition(bare, tmp_path)
    same(read_transition(tmp_path), bare)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["card.json", "geometry.npz"]


def test_same_transition_same_bytes(tmp_path):
    for name in ("a", "b"):
        write_transition(transition(), tmp_path / name)
    for file in sorted((tmp_path / "a").iterdir()):
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()


def test_names_sort_out_in_any_listing():
    assert [step_name(step) for step in (-9, 0, 9)] == ["step_-09", "step_00", "step_09"]
