import numpy as np
import pytest
import trimesh

from unstructured_mg.geometry.halfedges import match_halfedges
from unstructured_mg.geometry.laplacian import face_areas
from unstructured_mg.synthesis.refine import refine


@pytest.mark.parametrize("longest", [0.9, 0.31, 0.1])
def test_no_edge_stays_long_and_nothing_else_changes(longest):
    generator = np.random.default_rng(0)
    mesh = trimesh.creation.icosphere(subdivisions=1)
    vertices = mesh.vertices * [1, 0.5, 2] + generator.normal(scale=0.1, size=mesh.vertices.shape)
    faces = mesh.faces.astype(np.int32)
    lift, fine, corners = refine(vertices, faces, vertices[faces], longest)
    positions = lift @ vertices
    edges = positions[fine[:, [1, 2, 0]]] - positions[fine]
    assert np.linalg.norm(edges, axis=2).max() <= longest
    # Carried corner values stay those of the corners, area and closedness are kept, and normals keep their side.
    np.testing.assert_allclose(corners, positions[fine], atol=1e-12)
    np.testing.assert_allclose(face_areas(positions, fine).sum(), face_areas(vertices, faces).sum(), rtol=1e-12)
    assert (match_halfedges(positions, fine)[0] >= 0).all()
    signed = lambda v, f: np.einsum("fi,fi->", v[f[:, 0]], np.cross(v[f[:, 1]], v[f[:, 2]]))  # noqa: E731
    np.testing.assert_allclose(signed(positions, fine), signed(vertices, faces), rtol=1e-12)
    np.testing.assert_allclose(lift.sum(axis=1), 1)


def test_a_surface_that_is_fine_enough_stays_as_it_is():
    mesh = trimesh.creation.box()
    faces = mesh.faces.astype(np.int32)
    lift, fine, _ = refine(np.asarray(mesh.vertices), faces, np.zeros((12, 3, 2)), 2.0)
    np.testing.assert_array_equal(fine, faces)
    np.testing.assert_array_equal(lift.toarray(), np.eye(8))
