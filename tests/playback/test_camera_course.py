import numpy as np
import pytest
from memory_capture import box

from unstructured_mg.playback.camera_course import TURN_SECONDS, fixed_course, measure_figure, orbit_course

FPS = 10.0


def world(yaw, x, y):
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])


def walk(frames):
    """A box that grows, turns and goes 4 m."""
    meshes = [box((1, 2, 3), size=(0.4, 0.6, 1.5 + 0.3 * np.sin(i))) for i in range(frames)]
    worlds = [world(0.2 * i, 4 * i / frames, 0.5 * np.cos(0.3 * i)) for i in range(frames)]
    figures = [measure_figure(mesh.vertices, mesh.faces) for mesh in meshes]
    return meshes, worlds, figures


def seen(view, mesh, place):
    points = mesh.vertices @ place[:3, :3].T + place[:3, 3]
    x, y, _, w = view.camera.project(points).T
    assert (w > 0).all()
    return np.stack([x / w / view.camera.width, y / w / view.camera.height])


@pytest.mark.parametrize("height", [120, 721])
def test_every_frame_is_wholly_in_the_picture(height):
    meshes, worlds, figures = walk(60)
    for views in (fixed_course(figures, worlds, height), orbit_course(figures, worlds, height, FPS)):
        assert len(views) == 60
        sizes = {(view.camera.height, view.camera.width) for view in views}
        ((tall, wide),) = sizes
        assert tall == height // 2 * 2 and wide % 2 == 0
        at = np.stack([seen(view, mesh, place) for view, mesh, place in zip(views, meshes, worlds, strict=True)])
        assert at.min() > 0.03 and at.max() < 0.97
        # And no farther away than it must be: the walk reaches its margin in one direction at least.
        assert min(at.min(), 1 - at.max()) < 0.12


def test_a_fixed_camera_stands_still():
    _, worlds, figures = walk(20)
    first, *rest = fixed_course(figures, worlds, 200)
    assert all(view is first for view in rest)


def test_an_orbit_goes_once_around_in_its_time_at_one_distance():
    frames = round(TURN_SECONDS * FPS)
    mesh = box((1, 2, 3))
    figure = measure_figure(mesh.vertices, mesh.faces)
    views = orbit_course([figure] * (frames + 1), [np.eye(4)] * (frames + 1), 200, FPS)
    from_axis = np.stack([view.camera.position[:2] for view in views])
    np.testing.assert_allclose(np.hypot(*from_axis.T), np.hypot(*from_axis[0]), rtol=1e-9)
    np.testing.assert_allclose(from_axis[frames], from_axis[0], atol=1e-9)
    turned = np.diff(np.unwrap(np.arctan2(from_axis[:, 1], from_axis[:, 0])))
    np.testing.assert_allclose(turned, 2 * np.pi / frames, rtol=1e-6)


def test_an_orbit_follows_smoothly():
    _, worlds, figures = walk(60)
    rough = [place + np.array([[0, 0, 0, (-1) ** i * 0.1]] + [[0] * 4] * 3) for i, place in enumerate(worlds)]
    centres = np.stack([view.centre for view in orbit_course(figures, rough, 200, FPS)])
    assert np.abs(np.diff(centres, n=2, axis=0)).max() < 0.02


def test_debris_does_not_count():
    mesh = box((1, 2, 3))
    far = np.array([[9, 9, 9], [9.001, 9, 9], [9, 9.001, 9.0]])
    faces = np.concatenate([mesh.faces, [[8, 9, 10]]]).astype(np.int32)
    figure = measure_figure(np.concatenate([mesh.vertices, far]), faces)
    np.testing.assert_array_equal([figure.low, figure.high], [mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])
