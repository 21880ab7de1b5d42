import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from unstructured_mg.geometry.elements import element_deformations, element_forces, two_sided_targets


def random_elements(corners):
    rng = np.random.default_rng(corners)
    return rng.integers(0, 30, (50, corners)).astype(np.int32), rng.normal(size=(50, corners, 3)), rng


@pytest.mark.parametrize("corners", [3, 4])
def test_sums_equal_numpy(corners):
    elements, gradients, rng = random_elements(corners)
    vertices, sizes, shapes = rng.normal(size=(30, 3)), rng.random(50), rng.normal(size=(50, 3, 3))
    np.testing.assert_allclose(
        element_deformations(vertices, elements, gradients),
        np.einsum("qia,qib->qab", vertices[elements], gradients),
        atol=1e-13,
    )
    expected = np.zeros((30, 3))
    np.add.at(expected, elements, np.einsum("q,qab,qib->qia", sizes, shapes, gradients))
    np.testing.assert_allclose(element_forces(30, elements, gradients, sizes, shapes), expected, atol=1e-13)


def random_deformations(seed):
    rng = np.random.default_rng(seed)
    return Rotation.random(20, rng=rng).as_matrix() @ (np.eye(3) + 0.1 * rng.normal(size=(20, 3, 3)))


def test_targets_are_the_turned_rest_shapes_that_come_nearest():
    source, target, new = (random_deformations(seed) for seed in range(3))
    wanted = two_sided_targets(new, source, target, 0.0)
    best = np.linalg.norm(wanted - new, axis=(1, 2))
    for turn in Rotation.random(50, rng=np.random.default_rng(9)).as_matrix():
        assert (np.linalg.norm(turn @ source - new, axis=(1, 2)) >= best - 1e-12).all()
    np.testing.assert_allclose(two_sided_targets(target, source, target, 1.0), target, atol=1e-12)


def test_targets_meet_both_rests():
    source, target = random_deformations(0), random_deformations(1)
    np.testing.assert_allclose(two_sided_targets(source, source, target, 0.0), source, atol=1e-12)
    np.testing.assert_allclose(two_sided_targets(target, source, target, 1.0), target, atol=1e-12)


def test_wrong_arguments_are_named():
    elements, gradients, rng = random_elements(4)
    vertices, shapes = rng.normal(size=(30, 3)), rng.normal(size=(50, 3, 3))
    with pytest.raises(ValueError, match="elements: expected indices in 0..28"):
        element_deformations(vertices[:29], elements, gradients)
    with pytest.raises(ValueError, match="gradients"):
        element_deformations(vertices, elements, gradients[:, :3])
    with pytest.raises(ValueError, match="vertices"):
        element_deformations(vertices[:, :2], elements, gradients)
    with pytest.raises(ValueError, match="sizes"):
        element_forces(30, elements, gradients, np.ones(49), shapes)
    with pytest.raises(ValueError, match="shapes"):
        element_forces(30, elements, gradients, np.ones(50), shapes[:, :2])
    with pytest.raises(ValueError, match="target: expected finite"):
        two_sided_targets(shapes, shapes, np.full_like(shapes, np.nan), 0.5)
