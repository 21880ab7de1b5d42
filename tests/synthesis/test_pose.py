import numpy as np
import scipy.sparse as sp
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from unstructured_mg.synthesis.pose import parts_of, pose_parts


def test_each_part_is_placed_on_its_own():
    rng = np.random.default_rng(0)
    between = rng.normal(size=(40, 3))
    parts = np.arange(40) % 2
    new = between.copy()
    for part in (0, 1):
        new[parts == part] = between[parts == part] @ Rotation.from_rotvec(
            rng.normal(size=3)
        ).as_matrix().T + rng.normal(size=3)
    np.testing.assert_allclose(pose_parts(new, between, np.ones(40), parts), between, atol=1e-12)


def test_it_minimises_the_weighted_sum_over_both_frames():
    rng = np.random.default_rng(1)
    new, source, target = rng.normal(size=(3, 15, 3))
    masses, weight = rng.uniform(0.5, 2, 15), 0.3

    def energy(shape):
        return (1 - weight) * masses @ ((shape - source) ** 2).sum(1) + weight * masses @ ((shape - target) ** 2).sum(1)

    posed = pose_parts(new, (1 - weight) * source + weight * target, masses, np.zeros(15, int))
    best = min(
        minimize(lambda p: energy(new @ Rotation.from_rotvec(p[:3]).as_matrix().T + p[3:]), start, tol=1e-12).fun
        for start in rng.normal(size=(8, 6))
    )
    np.testing.assert_allclose(energy(posed), best, rtol=1e-8)


def test_a_part_without_mass_takes_the_blend():
    between = np.random.default_rng(2).normal(size=(6, 3))
    posed = pose_parts(between + 5, between, np.array([1.0, 1, 1, 0, 0, 0]), np.array([0, 0, 0, 1, 1, 1]))
    np.testing.assert_array_equal(posed[3:], between[3:])


def test_parts_are_what_is_coupled():
    stiffness = sp.csr_matrix(np.array([[1.0, 0, -1, 0], [0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 0]]))
    parts = parts_of(stiffness)
    assert parts[0] == parts[2] and len(set(parts[[0, 1, 3]].tolist())) == 3
