import numpy as np
import pytest
from toy_capture import toy_capture

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.playback.world import export_space

MOTION = PlanarRigid(0.7, 1.5, -2.0)
POINTS = np.random.default_rng(0).normal(size=(9, 3))


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_the_captures_own_space_is_gone_back_to(up):
    capture = toy_capture(3, unit=0.01, up=up, floor=7.0)
    space = export_space(capture)
    assert (space.up, space.unit) == (up, 0.01)
    own = POINTS * 100
    to_metres = capture.to_metres()
    np.testing.assert_allclose(space.points(own @ to_metres[:3, :3].T + to_metres[:3, 3]), own, atol=1e-12)


def test_world_moves_a_frames_own_place_in_the_exports_axis_and_unit():
    capture = toy_capture(3, unit=0.01, up="y", floor=7.0)
    for space in (export_space(capture), export_space(capture, up="-z"), export_space(capture, unit=1.0)):
        own, moved = space.points(POINTS), space.points(MOTION.apply(POINTS))
        world = space.world(MOTION)
        np.testing.assert_allclose(own @ world[:3, :3].T + world[:3, 3], moved, atol=1e-9)
    # Turning about y by 0.7 and shifting by centimetres in x and -z; the floor's height does not show.
    c, s = np.cos(0.7), np.sin(0.7)
    expected = [[c, 0, s, 150], [0, 1, 0, 0], [-s, 0, c, 200], [0, 0, 0, 1]]
    np.testing.assert_allclose(export_space(capture).world(MOTION), expected, atol=1e-9)


def test_a_frame_that_was_not_moved_has_exactly_the_identity():
    capture = toy_capture(3, unit=0.0254, up="y", floor=-3.3)
    world = export_space(capture).world(PlanarRigid())
    np.testing.assert_array_equal(world, np.eye(4))
    assert not np.signbit(world).any()


def test_another_unit_keeps_the_floor_where_it_is():
    capture = toy_capture(3, unit=0.01, up="y", floor=7.0)
    np.testing.assert_allclose(export_space(capture, unit=1.0).points(np.zeros((1, 3))), [[0, 0.07, 0]], atol=1e-15)


@pytest.mark.parametrize("unit", [0.0, -1.0, float("nan"), float("inf")])
def test_a_unit_is_positive(unit):
    with pytest.raises(ValueError, match="unit: expected a positive number of metres"):
        export_space(toy_capture(3), unit=unit)


def test_an_up_axis_is_one_of_six():
    with pytest.raises(ValueError, match="up: expected one of y, z, .*, got 'Y'"):
        export_space(toy_capture(3), up="Y")


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_the_floor_is_where_the_space_says(up):
    space = export_space(toy_capture(3, unit=0.01, up="y", floor=7.0), up=up, unit=0.1)
    on_floor = space.points(np.array([[0.3, -0.2, 0.0]]))[0]
    height = on_floor["xyz".index(up[-1])] * (-1 if up.startswith("-") else 1)
    assert (height, space.floor) == (pytest.approx(0.7), pytest.approx(0.7))
