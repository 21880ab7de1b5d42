import numpy as np
from scipy.spatial.transform import Rotation
from tracking.bodies import figure

from unstructured_mg.tracking.cage_lattice import lattice_cage
from unstructured_mg.tracking.embedding import embed, make_cage, residual_of, tet_rotations


def caged():
    vertices, faces = figure(24, 30)
    return vertices, lattice_cage(vertices, faces, 0.12)


def test_the_embedding_reproduces_the_surface_at_rest_also_outside_the_cells():
    vertices, (cage, tets, tet_of_vertex) = caged()
    outside = vertices * 1.3
    made = make_cage(cage, tets, outside, tet_of_vertex, "lattice")
    assert made.weights.min() >= -1e-9 and np.linalg.norm(made.residual, axis=1).max() > 0.01
    rotations = tet_rotations(cage, tets, cage)
    surface = embed(cage, tets, made.tet_of_vertex, made.weights, rotations, made.residual)
    np.testing.assert_allclose(surface, outside, atol=1e-12)
    assert not make_cage(cage, tets, vertices, tet_of_vertex, "lattice").residual.any()


def test_a_rigid_motion_of_the_cage_is_one_of_the_surface():
    vertices, (cage, tets, tet_of_vertex) = caged()
    outside = vertices * 1.3
    made = make_cage(cage, tets, outside, tet_of_vertex, "lattice")
    turn = Rotation.from_rotvec([1.0, -0.4, 2.0]).as_matrix()
    moved = cage @ turn.T + [1.0, 2.0, 3.0]
    rotations = tet_rotations(cage, tets, moved)
    surface = embed(moved, tets, made.tet_of_vertex, made.weights, rotations, made.residual)
    np.testing.assert_allclose(surface, outside @ turn.T + [1.0, 2.0, 3.0], atol=1e-10)


def test_residual_of_undoes_embed():
    vertices, (cage, tets, tet_of_vertex) = caged()
    made = make_cage(cage, tets, vertices, tet_of_vertex, "lattice")
    rng = np.random.default_rng(0)
    moved = cage + rng.normal(scale=0.01, size=cage.shape)
    rotations = tet_rotations(cage, tets, moved)
    wanted = vertices + rng.normal(scale=0.02, size=vertices.shape)
    residual = residual_of(wanted, moved, tets, made.tet_of_vertex, made.weights, rotations)
    surface = embed(moved, tets, made.tet_of_vertex, made.weights, rotations, residual)
    np.testing.assert_allclose(surface, wanted, atol=1e-12)
