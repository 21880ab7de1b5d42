import pytest

from unstructured_mg.playback.quality import QualityRow, plain_rows, quality_rows
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.quality import objections

LIMITS = SynthesisOptions(
    surface_jump=1.5,
    surface_jump_floor=0.002,
    velocity_jump=1.5,
    velocity_jump_floor=0.001,
    colour_jump=1.5,
    colour_jump_floor=4.0,
    volume_drift=0.05,
    inverted_tets=0,
    self_intersections=0.02,
    foot_slide=0.06,
    sharpness=0.6,
)
CARD = {
    "start": {
        "surface_m": 0.003,
        "surface": 0.75,
        "velocity_m": 0.002,
        "velocity": 1.25,
        "colour_levels": 6.5,
        "colour": 2.5,
        "twist": 2,
    },
    "end": {
        "surface_m": 0.0045,
        "surface": 1.75,
        "velocity_m": 0.0005,
        "velocity": None,
        "colour_levels": None,
        "colour": None,
    },
    "surface_change_m": 0.004,
    "volume_drift": 0.0625,
    "inverted_tets": 0,
    "self_intersections": 0.001,
    "foot_slide_m": 0.5,
    "texture": {"sharpness": 0.875, "holes_start": 0.25, "new_measure": 3, "seam_color_start": 6.5},
}


def test_what_is_judged_comes_first_with_its_limit_and_verdict():
    assert quality_rows(CARD, LIMITS) == [
        QualityRow("surface, first seam", "0.75 × (3 mm)", "1.5 × or 2 mm", "good"),
        QualityRow("surface, last seam", "1.75 × (4.5 mm)", "1.5 × or 2 mm", "poor"),
        QualityRow("velocity, first seam", "1.25 × (2 mm)", "1.5 × or 1 mm", "good"),
        QualityRow("velocity, last seam", "0.5 mm", "1.5 × or 1 mm", "good"),
        QualityRow("colour, first seam", "2.5 × (6.5 / 255)", "1.5 × or 4 / 255", "poor"),
        QualityRow("colour, last seam", "not measured"),
        QualityRow("sharpness of the middle to the ends", "0.875 ×", "at least 0.6 ×", "good"),
        QualityRow("volume drift", "6.25 %", "5 %", "poor"),
        QualityRow("cage cells inside out", "0", "0", "good"),
        QualityRow("more faces that cut others", "0.1 %", "2 %", "good"),
        QualityRow("slide of planted feet", "500 mm", "60 mm", "poor"),
        QualityRow("change of surface in the capture", "4 mm"),
        QualityRow("texture without a source, first seam", "25 %"),
        QualityRow("start: twist", "2"),
        QualityRow("new measure", "3"),
    ]
    assert quality_rows({}, LIMITS) == []


@pytest.mark.parametrize(
    "change",
    [
        {},
        {
            "start": {
                "surface_m": 0.0019,
                "surface": 9.0,
                "velocity_m": 0.0011,
                "velocity": None,
                "colour_levels": 3.5,
                "colour": 9.0,
            }
        },
        {"texture": {"sharpness": 0.5}},
        {"texture": {}},
        {"volume_drift": None, "inverted_tets": 3, "self_intersections": 0.5},
        {
            "foot_slide_m": 0.06,
            "end": {
                "surface_m": 0.0,
                "surface": 0.0,
                "velocity_m": 0.0,
                "velocity": 0.0,
                "colour_levels": 9.0,
                "colour": None,
            },
        },
    ],
)
def test_the_verdicts_are_those_of_the_synthesis(change):
    card = {**CARD, **change}
    poor = [row for row in quality_rows(card, LIMITS) if row.verdict == "poor"]
    assert len(poor) == len(objections(card, LIMITS))


def test_what_could_not_be_measured_is_said():
    assert QualityRow("volume drift", "not measured", "5 %") in quality_rows({**CARD, "volume_drift": None}, LIMITS)


def test_any_measures_become_rows():
    assert plain_rows(
        {
            "hausdorff_m": 0.183,
            "end_surface_m": 0.02,
            "end_surface": 2.5,
            "seams": {"start": 0.5, "end_m": None},
            "steps": [1, 2],
            "method": "a_b",
        }
    ) == [
        QualityRow("hausdorff", "183 mm"),
        QualityRow("end surface", "20 mm"),
        QualityRow("end surface", "2.5 ×"),
        QualityRow("seams: start", "0.5"),
        QualityRow("seams: end", "not measured"),
        QualityRow("steps", "1, 2"),
        QualityRow("method", "a_b"),
    ]
