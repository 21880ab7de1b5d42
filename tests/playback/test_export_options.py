import pytest

from unstructured_mg.playback.export_options import ExportOptions


@pytest.mark.parametrize(
    ("name", "value"),
    [("fps", 0.0), ("fps", float("nan")), ("fps", 1001.0), ("first_number", -1), ("hold", -1), ("up", "Y"),
     ("unit", 0.0), ("unit", float("inf")), ("camera", "drone"), ("picture_height", 5), ("decimate", 3),
     ("texture_size", 0)],
)  # fmt: skip
def test_a_bad_value_is_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}: expected .*, got "):
        ExportOptions(**{name: value})


def test_what_was_asked_for_is_what_differs_from_the_defaults():
    assert ExportOptions().given() == {}
    assert ExportOptions(bounce=True, up="z").given() == {"bounce": True, "up": "z"}
