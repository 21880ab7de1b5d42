import igl
import numpy as np
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

from unstructured_mg.geometry.arap import HeldArap, arap_energy
from unstructured_mg.geometry.tets import tet_volumes


def block():
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 5)] * 3, indexing="ij"), -1).reshape(-1, 3)
    grid = grid + np.random.default_rng(0).normal(scale=0.01, size=grid.shape)
    tets = Delaunay(grid).simplices.astype(np.int32)
    volumes = tet_volumes(grid, tets)
    tets[volumes < 0] = tets[volumes < 0][:, [0, 1, 3, 2]]
    return grid, tets[np.abs(volumes) > 1e-4]


def test_energy_is_zero_for_rigid_motions_and_analytic_for_a_stretch():
    rest, tets = block()
    turned = rest @ Rotation.from_rotvec([1, 2, 3]).as_matrix().T + 5
    assert arap_energy(rest, tets, turned) < 1e-20
    stretched = rest * [1.5, 1, 1]
    np.testing.assert_allclose(arap_energy(rest, tets, stretched), 0.25 * tet_volumes(rest, tets).sum())


def test_held_ends_turned_rigidly_turn_the_inside():
    rest, tets = block()
    held = np.flatnonzero((rest[:, 0] < 0.1) | (rest[:, 0] > 0.9))
    moved = rest @ Rotation.from_rotvec([0, 0, 0.7]).as_matrix().T
    start = rest.copy()
    start[held] = moved[held]
    solved = HeldArap(rest, tets, held).solve(start, iterations=200)
    np.testing.assert_allclose(solved, moved, atol=1e-4)


def test_a_bend_reaches_the_energy_of_libigl():
    rest, tets = block()
    held = np.flatnonzero((rest[:, 0] < 0.1) | (rest[:, 0] > 0.9))
    start = rest.copy()
    top = rest[held, 0] > 0.9
    start[held[top]] = rest[held[top]] @ Rotation.from_rotvec([0, 1.0, 0]).as_matrix().T + [0.2, 0, 0.3]
    ours = HeldArap(rest, tets, held).solve(start, iterations=20)

    data = igl.ARAPData()
    data.energy = igl.ARAP_ENERGY_TYPE_ELEMENTS
    data.max_iter = 20
    igl.arap_precomputation(rest, tets, 3, held, data)
    theirs = igl.arap_solve(start[held], data, start)
    np.testing.assert_allclose(arap_energy(rest, tets, ours), arap_energy(rest, tets, theirs), rtol=1e-6)
