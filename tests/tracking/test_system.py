import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tracking.bodies import figure

from unstructured_mg.geometry.arap import arap_energy
from unstructured_mg.geometry.tets import tet_gradients
from unstructured_mg.tracking.cage_lattice import lattice_cage
from unstructured_mg.tracking.system import CageSystem


@pytest.fixture
def rng():
    return np.random.default_rng(3)


@pytest.fixture
def cage():
    vertices, faces = figure(20, 30)
    return lattice_cage(vertices, faces, 0.15)[:2]


def dense(system, strength, rotations, rest, tets):
    """The ARAP matrix from the formula, one dense 3x3 block at a time."""
    gradients = tet_gradients(rest, tets)
    turned = np.einsum("qab,qib->qia", rotations, gradients)
    matrix = np.zeros((3 * len(rest), 3 * len(rest)))
    for q, tet in enumerate(tets):
        for i in range(4):
            for j in range(4):
                block = gradients[q, i] @ gradients[q, j] * np.eye(3) + np.outer(turned[q, j], turned[q, i])
                a, b = 3 * tet[i], 3 * tet[j]
                matrix[a : a + 3, b : b + 3] += strength[q] * system.volumes[q] * block
    return matrix


def test_the_system_solves_what_the_formulas_say(cage, rng):
    rest, tets = cage
    system = CageSystem(rest, tets)
    moved = rest @ Rotation.from_rotvec([0.3, 1, 0.2]).as_matrix().T + rng.normal(scale=0.01, size=rest.shape)
    linear, rotations = system.rotations(moved)
    strength = rng.random(len(tets)) + 0.5
    tet = rng.integers(0, len(tets), 300).astype(np.int32)
    weights, normals, pull = rng.random((300, 4)), rng.normal(size=(300, 3)), rng.random(300)
    offsets = rng.normal(size=300)
    blocks, right = system.new_terms()
    system.add_arap(blocks, right, moved, strength)
    system.add_planes(blocks, right, tet, weights, normals, pull, offsets)
    force = np.einsum("q,qab,qib->qia", strength * system.volumes, rotations - linear, tet_gradients(rest, tets))
    expected = np.zeros_like(rest)
    np.add.at(expected, tets, force)
    np.add.at(expected, tets[tet], (pull * offsets)[:, None, None] * weights[:, :, None] * normals[:, None, :])
    np.testing.assert_allclose(right, expected, atol=1e-12)
    matrix = dense(system, strength, rotations, rest, tets) + 0.1 * np.eye(3 * len(rest))
    for p in range(300):
        row = np.zeros(3 * len(rest))
        for i in range(4):
            row[3 * tets[tet[p], i] : 3 * tets[tet[p], i] + 3] += weights[p, i] * normals[p]
        matrix += pull[p] * np.outer(row, row)
    right = rng.normal(size=rest.shape)
    expected = np.linalg.solve(matrix, right.ravel()).reshape(-1, 3)
    np.testing.assert_allclose(system.solve(blocks, right, 0.1), expected, rtol=1e-8, atol=1e-10)


def test_the_arap_gradient_is_the_energys(cage, rng):
    rest, tets = cage
    system = CageSystem(rest, tets)
    moved = rest + rng.normal(scale=0.02, size=rest.shape)
    direction = rng.normal(size=rest.shape)
    h = 1e-6
    numeric = (arap_energy(rest, tets, moved + h * direction) - arap_energy(rest, tets, moved - h * direction)) / (
        2 * h
    )
    blocks, right = system.new_terms()
    system.add_arap(blocks, right, moved, np.ones(len(tets)))
    np.testing.assert_allclose(np.vdot(-2 * right, direction), numeric, rtol=1e-6)


def test_a_step_turns_a_body_without_resistance(cage):
    # The corotated matrix knows infinitesimal rotations: it gives no force for them.
    rest, tets = cage
    system = CageSystem(rest, tets)
    _, rotations = system.rotations(rest)
    matrix = dense(system, np.ones(len(tets)), rotations, rest, tets)
    spin = np.cross([0.2, 0.5, -0.3], rest).ravel()
    assert np.abs(matrix @ spin).max() < 1e-12


def test_kernels_refuse_indices_out_of_range(cage):
    rest, tets = cage
    system = CageSystem(rest, tets)
    blocks, right = system.new_terms()
    one = np.ones(1)
    with pytest.raises(IndexError):
        outside = np.array([len(tets)], np.int32)
        system.add_planes(blocks, right, outside, np.ones((1, 4)), np.ones((1, 3)), one, one)
    with pytest.raises(IndexError):
        system.add_arap(blocks[:1], right, rest, np.ones(len(tets)))
