import numpy as np
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from unstructured_mg.synthesis.two_sided import PinnedSolver, between_stretches


def random_deformations(seed):
    rng = np.random.default_rng(seed)
    stretch = np.eye(3) + 0.1 * rng.normal(size=(20, 3, 3))
    return Rotation.random(20, rng=rng).as_matrix() @ (stretch + stretch.transpose(0, 2, 1)) / 2


def test_between_meets_both_ends_and_mirrors():
    source, target = random_deformations(0), random_deformations(1)
    np.testing.assert_allclose(between_stretches(source, target, 0.0), source, atol=1e-12)
    np.testing.assert_allclose(between_stretches(source, target, 1.0), target, atol=1e-12)
    np.testing.assert_allclose(
        between_stretches(source, target, 0.3), between_stretches(target, source, 0.7), atol=1e-12
    )


def test_between_turns_at_even_speed():
    target = Rotation.from_rotvec([[0.4, -1.2, 2.0]]).as_matrix()
    third = Rotation.from_rotvec([[0.4 / 3, -0.4, 2.0 / 3]]).as_matrix()
    np.testing.assert_allclose(between_stretches(np.eye(3)[None], target, 1 / 3), third, atol=1e-12)


def test_the_pinned_solver_solves_with_every_part_at_its_pin():
    path = sp.csr_matrix(np.array([[1.0, -1, 0, 0, 0], [-1, 2, -1, 0, 0], [0, -1, 1, 0, 0], [0] * 5, [0] * 5]))
    places = np.arange(15.0).reshape(5, 3)
    right = path @ np.random.default_rng(0).normal(size=(5, 3))
    solved = PinnedSolver(path).solve(right, places)
    np.testing.assert_allclose(path @ solved, right, atol=1e-12)
    np.testing.assert_allclose(solved[[3, 4]], places[[3, 4]], atol=1e-12)
    assert np.isclose(solved[:3], places[:3]).all(axis=1).sum() == 1
