import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from unstructured_mg.geometry.rotations import fit_planar, fit_rigid, fit_rotations


def by_svd(matrix):
    u, _, vt = np.linalg.svd(matrix)
    return u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt


def test_equals_the_svd_also_for_reflections():
    matrices = np.random.default_rng(0).normal(size=(500, 3, 3))
    assert (np.linalg.det(matrices) < 0).sum() > 100
    expected = np.array([by_svd(matrix) for matrix in matrices])
    np.testing.assert_allclose(fit_rotations(matrices), expected, atol=1e-9)


def test_singular_matrices_still_give_rotations():
    matrices = np.zeros((3, 3, 3))
    matrices[1] = np.outer([1, 2, 3], [0, 1, 0])
    matrices[2] = np.diag([1.0, 1.0, 0.0])
    rotations = fit_rotations(matrices)
    np.testing.assert_allclose(rotations @ rotations.transpose(0, 2, 1), np.eye(3)[None].repeat(3, 0), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(rotations), 1, atol=1e-12)
    np.testing.assert_allclose(rotations[2], np.eye(3), atol=1e-9)


def test_rigid_and_planar_fits_recover_known_motions():
    rng = np.random.default_rng(1)
    points, weights = rng.normal(size=(50, 3)), rng.random(50)
    rotation = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix()
    found, shift = fit_rigid(points, points @ rotation.T + [1, 2, 3], weights)
    np.testing.assert_allclose(found, rotation, atol=1e-9)
    np.testing.assert_allclose(shift, [1, 2, 3], atol=1e-9)

    turn = Rotation.from_rotvec([0, 0, 2.5]).as_matrix()
    motion = fit_planar(points, points @ turn.T + [4, 5, 0], weights)
    np.testing.assert_allclose([motion.yaw, motion.x, motion.y], [2.5, 4, 5], atol=1e-9)


@pytest.mark.parametrize("bad", [np.zeros((3, 3)), np.full((1, 3, 3), np.nan)])
def test_bad_matrices_are_named(bad):
    with pytest.raises(ValueError, match="matrices: expected"):
        fit_rotations(bad)
