import numpy as np
from toy_pair import club

from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.synthesis.align import vertex_areas
from unstructured_mg.synthesis.blend_linear import LinearBlend
from unstructured_mg.synthesis.feet import find_feet, lock, plant_feet
from unstructured_mg.synthesis.posture import Posture, Template
from unstructured_mg.synthesis.quality import foot_slide
from unstructured_mg.synthesis.weights import cubic_weights

STEPS = 20
WEIGHTS = cubic_weights(STEPS // 2)


def test_a_foot_that_swings_later_is_held_exactly_and_catches_up():
    stands = np.arange(STEPS) < 8
    slides = 0.1 * np.diff(WEIGHTS)[:, None] * [1.0, -0.5]
    correction = lock(slides, stands, turn=1.0)
    np.testing.assert_allclose(np.diff(correction, axis=0)[stands], -slides[stands], atol=1e-6)
    np.testing.assert_allclose(correction[[0, -1]], 0, atol=1e-6)


def test_a_foot_that_never_swings_slides_evenly():
    """It has to get to where the target stands: with the whole way the same, least squares makes its steps equal."""
    slides = 0.1 * np.diff(WEIGHTS)[:, None] * [1.0, 0.0]
    correction = lock(slides, np.ones(STEPS, bool), turn=1.0)
    np.testing.assert_allclose((np.diff(correction, axis=0) + slides)[:, 0], 0.1 / STEPS, atol=1e-5)


def test_velocity_never_changes_by_more_than_the_bound():
    stands = (np.arange(STEPS) < 9) | (np.arange(STEPS) > 15)
    slides = 0.2 * np.diff(WEIGHTS)[:, None] * [1.0, 1.0]
    for turn in (0.0, 0.001, 0.01):
        correction = lock(slides, stands, turn)
        rest = np.zeros((1, 2))
        assert np.abs(np.diff(np.concatenate([rest, correction, rest]), n=2, axis=0)).max() <= turn + 1e-6


def test_time_turned_round_gives_the_same_correction():
    stands = np.arange(STEPS) < 8
    slides = 0.1 * np.diff(WEIGHTS)[:, None] * [1.0, -0.5]
    there, back = lock(slides, stands, 0.004), lock(-slides[::-1], stands[::-1], 0.004)
    np.testing.assert_allclose(there, back[::-1], atol=1e-7)


def two_clubs() -> Template:
    """Two legs a metre high and 0.4 m apart, each with a cage of its own."""
    one = club()
    aside, count, cells = np.array([0.0, 0.4, 0.0]), len(one.surface), len(one.cage)
    return Template(
        np.concatenate([one.surface, one.surface + aside]),
        np.concatenate([one.faces, one.faces + count]),
        np.concatenate([one.cage, one.cage + aside]),
        np.concatenate([one.tets, one.tets + cells]),
        np.concatenate([one.tet_of_vertex, one.tet_of_vertex + len(one.tets)]),
        np.concatenate([one.weights, one.weights]),
        np.concatenate([one.frames, one.frames + aside], axis=1),
    )


def walking(template, ways, lifts):
    """Postures with each leg moved by ``ways`` (steps, 2 legs, 2) on the floor and ``lifts`` (steps, 2) up."""
    postures = []
    for way, lift in zip(ways, lifts, strict=True):
        moves = np.column_stack([way, lift])
        postures.append(
            Posture(
                template.surface + np.repeat(moves, len(template.surface) // 2, axis=0),
                template.cage + np.repeat(moves, len(template.cage) // 2, axis=0),
            )
        )
    return postures


def test_legs_that_stand_in_turn_no_longer_slide():
    template = two_clubs()
    left_stands = np.arange(STEPS + 1) < 9
    lifts = 0.2 * np.column_stack([~left_stands, left_stands])
    arc = np.sin(np.linspace(0, 3, STEPS + 1))[:, None, None] * np.array([0.3, 0.0])
    swing = arc * (lifts > 0)[:, :, None]
    first, second = (walking(template, swing + off, lifts) for off in (np.zeros(2), np.array([0.06, -0.04])))
    blend = LinearBlend(template)
    steps = [blend(a, b, w) for a, b, w in zip(first, second, WEIGHTS, strict=True)]
    planted = plant_feet(template, steps, first, second, WEIGHTS)
    shapes = [np.stack([posture.surface for posture in way]) for way in (planted, first, second)]
    masses = vertex_areas(template.surface, template.faces)
    before = foot_slide(np.stack([posture.surface for posture in steps]), *shapes[1:], masses)
    assert before > 0.04 and foot_slide(*shapes, masses) < 0.003
    for end in (0, -1):
        np.testing.assert_array_equal(planted[end].surface, steps[end].surface)
        np.testing.assert_array_equal(planted[end].cage, steps[end].cage)
    # Soles go where they are sent, and no cell of the cage turns over.
    assert min(tet_volumes(posture.cage, template.tets).min() for posture in planted) > 0
    np.testing.assert_array_equal(shapes[0][:, :, 2], np.stack([posture.surface for posture in steps])[:, :, 2])


def test_each_leg_is_one_foot_and_what_never_stands_is_none():
    template = two_clubs()
    lowest = template.surface[:, 2]
    feet = find_feet(template, lowest, lowest < 0.02)
    half = len(template.surface) // 2
    assert len(feet) == 2 and not (feet[0] & feet[1]).any()
    assert feet[0][:half].any() and not feet[0][half:].any() and feet[1][half:].any()
    assert find_feet(template, lowest, np.zeros(len(lowest), bool)) == []
    assert find_feet(template, lowest + 1, lowest < 0.02) == []


def test_without_anything_that_stands_the_steps_stay():
    template = two_clubs()
    high = walking(template, np.zeros((STEPS + 1, 2, 2)), np.ones((STEPS + 1, 2)))
    assert plant_feet(template, high, high, high, WEIGHTS) == high
