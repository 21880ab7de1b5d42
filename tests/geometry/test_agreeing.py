import numpy as np
import pytest
import trimesh

from unstructured_mg.geometry.agreeing import AgreeingPoints
from unstructured_mg.geometry.normals import face_normals


def test_agrees_with_brute_force():
    generator = np.random.default_rng(0)
    mesh = trimesh.creation.icosphere(subdivisions=2)
    vertices = mesh.vertices + generator.normal(scale=0.05, size=mesh.vertices.shape)
    faces = mesh.faces.astype(np.int32)
    points = generator.normal(size=(300, 3))
    normals = generator.normal(size=(300, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    face, weights, distance = AgreeingPoints(vertices, faces).query(points, normals, 0.6, 0.4)
    flat = face_normals(vertices, faces)
    triangles = vertices[faces]
    assert (face < 0).any() and (face >= 0).any()
    for p, n, f, w, d in zip(points, normals, face, weights, distance, strict=True):
        nearest = trimesh.triangles.closest_point(triangles, np.broadcast_to(p, (len(faces), 3)))
        gaps = np.where(flat @ n >= 0.4, np.linalg.norm(nearest - p, axis=1), np.inf)
        if gaps.min() >= 0.6:
            assert f == -1 and d == np.inf
        else:
            np.testing.assert_allclose(d, gaps.min(), atol=1e-12)
            np.testing.assert_allclose(w @ triangles[f], nearest[gaps.argmin()], atol=1e-9)
            assert flat[f] @ n >= 0.4


def test_faces_without_area_are_never_found():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2.0, 0, 0]])
    faces = np.array([[0, 1, 3], [0, 1, 2]], np.int32)
    face, _, _ = AgreeingPoints(vertices, faces).query(np.array([[1.5, 0, 0.0]]), np.array([[0, 0, 1.0]]), 5, 1e-12)
    assert face.tolist() == [1]


@pytest.mark.parametrize(
    "vertices, faces",
    [
        (np.zeros((3, 3)), np.zeros((0, 3), np.int32)),
        (np.zeros((3, 3)), np.array([[0, 1, 3]], np.int32)),
        (np.full((3, 3), np.nan), np.array([[0, 1, 2]], np.int32)),
    ],
)
def test_unusable_meshes_are_refused(vertices, faces):
    with pytest.raises(ValueError):
        AgreeingPoints(vertices, faces)
