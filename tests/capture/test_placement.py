from functools import cache

import numpy as np
import pytest
from real_captures import real_capture

from unstructured_mg.capture.placement import UNITS, UP_AXES, FrameBounds, frame_bounds, place

RNG = np.random.default_rng(0)


def body(height=1.7, shift=(0, 0, 0), arms=0.3):
    """Vertices of a standing figure, y up: two feet, legs, a torso that is most of it, a head."""
    parts = []
    for count, low, high, radius, x in (
        (150, 0.0, 0.05, 0.1, -0.12),
        (150, 0.0, 0.05, 0.1, 0.12),
        (300, 0.05, 0.48, 0.07, -0.1),
        (300, 0.05, 0.48, 0.07, 0.1),
        (900, 0.48, 0.85, 0.18, 0.0),
        (200, 0.5, 0.82, 0.05, arms),
        (200, 0.5, 0.82, 0.05, -arms),
        (200, 0.87, 1.0, 0.1, 0.0),
    ):
        angle, level = RNG.uniform(0, 2 * np.pi, count), RNG.uniform(low, high, count)
        parts.append(np.column_stack([x + radius * np.cos(angle), height * level, radius * np.sin(angle)]))
    return np.vstack(parts) + shift


@cache
def performance(frames=30, jump=0.0):
    """A figure that walks 2 m, nods and crouches a little, feet on the floor but for a jump in the middle third."""
    bodies = []
    for i in range(frames):
        time = i / frames
        lift = jump * np.sin(3 * np.pi * (time - 1 / 3)) if 1 / 3 < time < 2 / 3 else 0.0
        figure = body(1.7 - 0.05 * np.sin(20 * time) ** 2, (0.2 * np.sin(9 * time), 0, 2 * time))
        bodies.append(figure + [0, lift, 0])
    return tuple(bodies)


def turned(bodies, up):
    """The same seen in axes of which `up` is the one up; UP_AXES takes it back."""
    return [figure[:, [0, 2, 1]] * [1, -1, 1] @ np.array(UP_AXES[up]) for figure in bodies]


@pytest.mark.parametrize("up", UP_AXES)
def test_up_axes_are_rotations_that_take_up_to_z(up):
    matrix = np.array(UP_AXES[up])
    np.testing.assert_array_equal(matrix @ matrix.T, np.eye(3))
    assert np.linalg.det(matrix) == pytest.approx(1)
    direction = np.eye(3)["xyz".index(up[-1])] * (-1 if up[0] == "-" else 1)
    np.testing.assert_array_equal(matrix @ direction, [0, 0, 1])


@pytest.mark.parametrize("up", ["y", "z", "-y", "-z"])
@pytest.mark.parametrize("unit", ["m", "dm", "cm", "mm"])
def test_unit_and_up_of_a_walking_figure(up, unit):
    bodies = [figure / UNITS[unit] for figure in turned(performance(), up)]
    placement = place([frame_bounds(figure) for figure in bodies], None, None, None)
    assert (placement.up, placement.unit, placement.warnings) == (up, UNITS[unit], ())
    assert placement.floor * placement.unit == pytest.approx(0.0, abs=0.005)


def test_up_is_found_wherever_the_origin_lies():
    for origin in ([0, 1.6, 0], [0, -3, 2], [5, 0.8, -5]):  # at the head, as from a held camera; anywhere
        placement = place([frame_bounds(figure - origin) for figure in performance()], None, None, None)
        assert placement.up == "y" and placement.floor == pytest.approx(-origin[1], abs=0.005)


def test_a_jump_does_not_lift_the_floor_and_debris_below_does_not_lower_it():
    bodies = performance(jump=0.6)
    debris = [0.001 * RNG.normal(size=(4, 3)) - [0, 0.5, 0] for _ in bodies]
    bodies = [np.vstack([figure, crumbs]) for figure, crumbs in zip(bodies, debris, strict=True)]
    for i in (7, 29):  # and in a few frames half the room comes along
        bodies[i] = np.vstack([bodies[i], RNG.uniform(-2, -0.4, (500, 3))])
    placement = place([frame_bounds(figure) for figure in bodies], 1.0, "y", None)
    assert placement.floor == pytest.approx(0.0, abs=0.005)


def test_a_jump_through_most_of_the_capture_leaves_the_floor_where_the_feet_were():
    bounds = [frame_bounds(body(shift=(0, 0.4 if i % 6 else 0.0, 0))) for i in range(24)]
    assert place(bounds, 1.0, "y", None).floor == pytest.approx(0.0, abs=0.005)


def test_what_is_given_is_taken():
    placement = place([frame_bounds(body())], 0.0254, "-z", 12.5)
    assert (placement.unit, placement.up, placement.floor, placement.warnings) == (0.0254, "-z", 12.5, ())


def test_a_lone_outstretched_figure_is_not_stood_on_its_head_and_doubt_is_said():
    placement = place([frame_bounds(body(arms=0.85))], None, None, None)
    assert placement.up == "y" and any("which way is up" in warning for warning in placement.warnings)
    lying = place([frame_bounds(figure) for figure in turned([body(arms=0.85)], "z")], None, None, None)
    assert lying.up == "z"


def test_half_a_body_is_said_to_be_none_and_not_scaled_up():
    placement = place([FrameBounds((-0.2, -0.2, 0.1), (0.2, 0.2, 0.3), (0.0, 0.0, 0.2))] * 5, None, None, None)
    assert (placement.unit, placement.up) == (1.0, "y") and len(placement.warnings) == 2


def test_bounds_leave_out_the_outermost_vertices_of_each_axis():
    line = np.linspace(0, 1, 1001)[:, None] * [1.0, 2.0, 3.0]
    spiked = np.vstack([line, [[-50, 9, 1]]])
    bounds = frame_bounds(spiked)
    np.testing.assert_allclose(bounds.low, [0.001, 0.004, 0.006], atol=2e-3)
    np.testing.assert_allclose(bounds.high, [0.998, 1.998, 2.994], atol=3e-3)


def test_real_registered_captures_in_any_axis():
    for name in ("mit_crane", "mit_samba"):
        vertices = np.load(real_capture(name, ":", "--npz") / f"{name}.npz")["vertices"][::5]
        for up in ("y", "z", "-y", "-z"):
            bounds = [frame_bounds(figure) for figure in turned(list(vertices * 1000), up)]
            placement = place(bounds, None, None, None)
            assert (placement.up, placement.unit, placement.warnings) == (up, 0.001, ())
