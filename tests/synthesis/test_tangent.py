import numpy as np
import trimesh
from textured_pairs import grid

from unstructured_mg.geometry.tracing import TracingSurface
from unstructured_mg.synthesis.project import smooth_normals
from unstructured_mg.synthesis.tangent import TangentFields


def fields_of(vertices, faces):
    return TangentFields(vertices, smooth_normals(vertices, faces), TracingSurface(vertices, faces))


def components(fields, vectors):
    return np.einsum("nac,nc->na", fields.axes, vectors)


def test_on_a_plane_the_energy_is_that_of_two_scalar_fields():
    vertices, faces = grid(20, 20)
    fields = fields_of(vertices, faces)
    linear = vertices @ np.array([[1.0, 3, 0], [-2, 0.5, 0], [0, 0, 0]])
    flat = components(fields, linear).ravel()
    # |grad|^2 of (x - 2 y, 3 x + y / 2) is 1 + 4 + 9 + 1/4 everywhere. The weight of diagonals adds a hundredth.
    np.testing.assert_allclose(flat @ fields.stiffness @ flat, 14.25, rtol=0.02)
    constant = components(fields, np.broadcast_to([0.3, -0.7, 0], vertices.shape)).ravel()
    np.testing.assert_allclose(constant @ fields.stiffness @ constant, 0, atol=1e-12)


def test_on_a_sphere_the_energy_of_a_spin_is_the_known_one():
    sphere = trimesh.creation.icosphere(subdivisions=5)
    vertices, faces = np.asarray(sphere.vertices), sphere.faces.astype(np.int32)
    fields = fields_of(vertices, faces)
    spin = components(fields, np.cross([0, 0, 1.0], vertices)).ravel()
    # A Killing field K on the unit sphere has Delta K = -K, so its energy is its square norm, 8 pi / 3.
    np.testing.assert_allclose(spin @ fields.stiffness @ spin, 8 * np.pi / 3, rtol=0.01)


def test_corner_vectors_are_the_vertex_vectors_where_the_surface_is_flat():
    vertices, faces = grid(5, 5)
    fields = fields_of(vertices, faces)
    vectors = np.random.default_rng(0).normal(size=vertices.shape) * [1, 1, 0]
    corners = fields.at_corners(components(fields, vectors), faces)
    np.testing.assert_allclose(np.linalg.norm(corners, axis=2), np.linalg.norm(vectors[faces], axis=2))
    x = vertices[faces[:, 1]] - vertices[faces[:, 0]]
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    np.testing.assert_allclose(corners[:, :, 0], np.einsum("fic,fc->fi", vectors[faces], x), atol=1e-12)


def test_matrix_is_symmetric_and_never_negative():
    generator = np.random.default_rng(1)
    mesh = trimesh.creation.icosphere(subdivisions=2)
    fields = fields_of(
        mesh.vertices + generator.normal(scale=0.05, size=mesh.vertices.shape), mesh.faces.astype(np.int32)
    )
    matrix = fields.stiffness.toarray()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12)
    assert np.linalg.eigvalsh(matrix).min() > 0
