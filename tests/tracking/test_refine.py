import numpy as np
from scipy.spatial.transform import Rotation
from tracking.bodies import tube

from unstructured_mg.tracking.refine import Refiner
from unstructured_mg.tracking.surface import clean_surface
from unstructured_mg.tracking.target import Target


def test_a_smooth_gap_is_closed_along_the_normal_and_not_sideways():
    vertices, faces = tube(0.2, 1.0, 60, 40)
    surface = clean_surface(vertices, faces)
    swollen, other_faces = tube(0.205, 1.0, 83, 61)
    refined = Refiner(surface, 0.01, 0.05).refine(vertices, Target(clean_surface(swollen, other_faces), 0.03, 0.1), 3)
    side = np.abs(vertices[:, 0]) < 0.3
    radius = np.linalg.norm(refined[side, 1:], axis=1)
    np.testing.assert_allclose(radius, 0.205, atol=3e-4)
    angle = np.arctan2(refined[side, 2], refined[side, 1]) - np.arctan2(vertices[side, 2], vertices[side, 1])
    assert np.abs(np.sin(angle)).max() * 0.2 < 2e-4
    assert np.abs(refined[side, 0] - vertices[side, 0]).max() < 2e-4


def test_a_target_beyond_reach_pulls_nothing():
    vertices, faces = tube(0.2, 1.0, 40, 20)
    far = Target(clean_surface(vertices + [0.0, 0.0, 3.0], faces), 0.03, 0.1)
    np.testing.assert_allclose(
        Refiner(clean_surface(vertices, faces), 0.01, 0.05).refine(vertices, far, 2), vertices, atol=1e-12
    )


def test_a_surface_that_was_pushed_about_along_itself_gets_its_metric_back():
    vertices, faces = tube(0.2, 1.0, 60, 40)
    turn = Rotation.from_rotvec([0.0, 0.0, 0.4]).as_matrix()
    creased = vertices + np.outer(4e-3 * np.sin(60 * vertices[:, 0]), [1.0, 0.0, 0.0])
    other, other_faces = tube(0.2, 1.0, 83, 61)
    goal = Target(clean_surface(other @ turn.T, other_faces), 0.03, 0.1)
    refined = Refiner(clean_surface(vertices, faces), 0.02, 0.05).refine(creased @ turn.T, goal, 8)
    side = np.abs(vertices[:, 0]) < 0.35
    before, after = (np.linalg.norm(v - vertices @ turn.T, axis=1)[side] for v in (creased @ turn.T, refined))
    assert np.sqrt(np.mean(before**2)) > 2.7e-3
    assert np.sqrt(np.mean(after**2)) < 3e-4
