import numpy as np
import pytest

from unstructured_mg.playback.camera import fit_camera, view_rotation


@pytest.mark.parametrize("azimuth", [0.0, 1.0, -2.5])
@pytest.mark.parametrize("elevation", [-0.4, 0.0, 0.9])
def test_view_rotation_is_upright_and_looks_back_at_the_subject(azimuth, elevation):
    right, up, forward = view_rotation(azimuth, elevation)
    np.testing.assert_allclose(
        np.stack([right, up, -forward]) @ np.stack([right, up, -forward]).T, np.eye(3), atol=1e-12
    )
    np.testing.assert_allclose(np.cross(right, up), -forward, atol=1e-12)
    towards = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    np.testing.assert_allclose(-forward, towards, atol=1e-12)
    assert right[2] == 0 and up[2] > 0


@pytest.mark.parametrize("field_of_view", [0.0, 0.3, 1.2])
def test_fit_holds_every_point_and_wastes_nothing(field_of_view):
    rng = np.random.default_rng(0)
    sets = [rng.normal(size=(50, 3)) * [0.3, 0.5, 1.0] + [4, 5, 1], rng.normal(size=(20, 3)) * 0.4 + [4.5, 5, 1]]
    camera = fit_camera(
        sets, height=300, width=200, azimuth=0.7, elevation=0.2, field_of_view=field_of_view, margin=0.1
    )
    picture = np.concatenate([camera.project(points) for points in sets])
    assert (picture[:, 3] > 0).all()
    x, y = picture[:, 0] / picture[:, 3], picture[:, 1] / picture[:, 3]
    slack = np.array([x.min() - 20, 180 - x.max(), y.min() - 30, 270 - y.max()])
    assert slack.min() > -1e-9
    assert slack.min() < 1e-9


def test_projected_points_lie_on_their_pixel_rays():
    points = np.random.default_rng(1).normal(size=(40, 3))
    camera = fit_camera([points], height=120, width=160, azimuth=2.0, elevation=0.3)
    picture = camera.project(points)
    x, y = picture[:, 0] / picture[:, 3] - 80, 60 - picture[:, 1] / picture[:, 3]
    ray = np.stack([x, y, np.full(40, camera.scale)], axis=1) @ camera.rotation
    offset = points - camera.position
    cosine = (ray * offset).sum(1) / np.linalg.norm(ray, axis=1) / np.linalg.norm(offset, axis=1)
    np.testing.assert_allclose(cosine, 1, atol=1e-12)
    assert (np.argsort(picture[:, 2] / picture[:, 3]) == np.argsort(offset @ camera.rotation[2])).all()


def test_one_point_still_gets_a_picture():
    for field_of_view in (0.0, 0.4):
        camera = fit_camera([np.zeros((1, 3))], height=10, width=10, azimuth=0.0, field_of_view=field_of_view)
        picture = camera.project(np.zeros((1, 3)))[0]
        np.testing.assert_allclose(picture[:2] / picture[3], [5, 5])


@pytest.mark.parametrize(
    ("change", "message"),
    [({"margin": 0.5}, "margin: expected"), ({"field_of_view": 4.0}, "field_of_view: expected")],
)
def test_bad_arguments_are_named(change, message):
    with pytest.raises(ValueError, match=message):
        fit_camera([np.zeros((1, 3))], height=10, width=10, azimuth=0.0, **change)
    with pytest.raises(ValueError, match="point_sets: expected"):
        fit_camera([np.zeros((0, 3))], height=10, width=10, azimuth=0.0)
