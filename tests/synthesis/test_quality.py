import dataclasses

import numpy as np
import pytest
import trimesh
from toy_pair import bending_pair, club

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis import quality
from unstructured_mg.synthesis.blend import blend_postures, windows_of
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.posture import Posture
from unstructured_mg.synthesis.weights import WEIGHTS


def card_of(pair, options, jumps=(0.0, 0.0), change=1.0):
    first, second = windows_of(pair, PlanarRigid(), False)
    steps = blend_postures(pair, PlanarRigid(), options, False)
    weights = WEIGHTS[options.weights](pair.k)
    windows = tuple(pair.vertices[window] for window in pair.windows)
    return quality.quality_card(steps, first, second, windows, weights, pair.faces, pair.tets, jumps, change)


def test_volume_of_a_sphere_and_of_an_open_one():
    ball = trimesh.creation.icosphere(subdivisions=3)
    faces = np.asarray(ball.faces, np.int32)
    np.testing.assert_allclose(quality.volume(ball.vertices + 7, faces), ball.volume)
    assert quality.is_closed(ball.vertices, faces)
    assert not quality.is_closed(ball.vertices, faces[:-1])


def test_a_normal_step_is_counted_and_a_tangential_one_is_not():
    ball = trimesh.creation.icosphere(subdivisions=4)
    vertices, faces = np.asarray(ball.vertices), np.asarray(ball.faces, np.int32)
    np.testing.assert_allclose(quality.normal_change(np.stack([vertices, 1.01 * vertices]), faces), 0.01, rtol=0.01)
    turned = PlanarRigid(0.01).apply(vertices)
    assert quality.normal_change(np.stack([vertices, turned]), faces) < 1e-4


def test_two_balls_in_each_other_intersect():
    ball = trimesh.creation.icosphere(subdivisions=2)
    vertices = np.concatenate([ball.vertices, ball.vertices + [1.0, 0, 0]])
    faces = np.concatenate([ball.faces, ball.faces + len(ball.vertices)])
    assert quality.intersecting_share(ball.vertices, ball.faces) == 0
    assert 0.05 < quality.intersecting_share(vertices, faces) < 0.5


def test_feet_that_glide_are_measured_and_feet_that_step_are_not():
    ground = np.array([[0.0, 0, 0], [0.1, 0, 0.01], [0, 0.1, 0.5]])
    still = np.repeat(ground[None], 5, axis=0)
    gliding = still + np.linspace(0, 0.2, 5)[:, None, None] * [1, 0, 0]
    np.testing.assert_allclose(quality.foot_slide(gliding, still, still, np.ones(3)), 0.2)
    assert quality.foot_slide(gliding, gliding, still, np.ones(3)) == 0


def test_a_cubic_blend_keeps_the_velocity_and_a_linear_one_does_not():
    pair = bending_pair(5, np.linspace(0, 0.2, 11) ** 1.5, 0.3 + np.linspace(0, 0.2, 11) ** 1.5)
    cubic, linear = (card_of(pair, SynthesisOptions(weights=name)) for name in ("cubic", "linear"))
    for seam in ("start", "end"):
        assert cubic[seam]["velocity_m"] < 0.35 * linear[seam]["velocity_m"]


def test_a_held_frame_does_not_pass_for_the_captures_own_stop():
    """A warp that holds frames makes the blend halt; the card measures that by how the windows themselves move."""
    pair = bending_pair(5, np.linspace(0, 0.5, 11), np.linspace(0, 0.5, 11))
    held = np.array([[0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8], [11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21]], np.int32)
    straight, halting = (card_of(p, SynthesisOptions()) for p in (pair, dataclasses.replace(pair, warp=held)))
    assert halting["velocity_change_m"] == straight["velocity_change_m"]
    assert halting["start"]["velocity_m"] > 20 * straight["start"]["velocity_m"]


def test_identical_windows_make_a_blameless_card():
    angles = np.linspace(0, 0.6, 7)
    card = card_of(bending_pair(3, angles, angles), SynthesisOptions())
    assert card["start"]["velocity_m"] < 1e-6 and card["end"]["velocity_m"] < 1e-6
    assert card["volume_drift"] < 1e-6 and card["inverted_tets"] == 0 and card["self_intersections"] == 0
    assert quality.objections(card, SynthesisOptions()) == []


def test_linear_blending_of_a_wide_bend_is_refused_for_its_volume():
    pair = bending_pair(3, np.linspace(0.0, 0.1, 7), np.linspace(1.9, 2.0, 7))
    card = card_of(pair, SynthesisOptions(blend="linear"))
    good = card_of(pair, SynthesisOptions())
    assert good["volume_drift"] < 0.1 * card["volume_drift"]
    assert any("volume" in clause for clause in quality.objections(card, SynthesisOptions()))


def test_turned_out_cells_are_counted_where_both_frames_are_sound():
    template = club()
    sound = Posture(template.surface, template.cage)
    flat = template.cage.copy()
    flat[:, 0] *= -1
    turned = Posture(template.surface, flat)
    count = len(template.tets)
    assert quality.inverted_tets([sound, turned], [sound, sound], [sound, sound], template.tets) == count
    assert quality.inverted_tets([turned], [turned], [sound], template.tets) == 0
    assert quality.inverted_tets([Posture(template.surface, None)], [sound], [sound], template.tets) is None


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"inverted_tets": 1}, "inside out"),
        ({"foot_slide_m": 1.0}, "feet"),
        ({"self_intersections": 0.5}, "cut through"),
        (
            {"start": {"surface": 1.6, "surface_m": 0.1, "velocity": 0.0, "velocity_m": 0.0}},
            "surface jumps at its start",
        ),
        ({"end": {"velocity": None, "velocity_m": 0.1}}, "still"),
        ({"end": {"colour": 1.6, "colour_levels": 20.0}}, "colour jumps at its end by 20.0 grey levels"),
        ({"texture": {"sharpness": 0.2}}, "sharp"),
    ],
)
def test_each_threshold_refuses(change, word):
    angles = np.linspace(0, 0.6, 7)
    card = card_of(bending_pair(3, angles, angles), SynthesisOptions())
    for key, value in change.items():
        card[key] = card[key] | value if isinstance(value, dict) else value
    clauses = quality.objections(card, SynthesisOptions())
    assert len(clauses) == 1 and word in clauses[0]


def test_colour_is_measured_against_the_captures_own_change():
    angles = np.linspace(0, 0.6, 7)
    bare = card_of(bending_pair(3, angles, angles), SynthesisOptions())
    card = quality.with_texture(bare, 4.0, {"seam_color_start": 6.0, "seam_color_end": 1.0, "sharpness": 0.9})
    assert (card["start"]["colour"], card["end"]["colour"]) == (1.5, 0.25)
    assert card["texture"]["sharpness"] == 0.9 and card["colour_change_levels"] == 4.0
    assert quality.with_texture(bare, None, {})["start"]["colour"] is None
