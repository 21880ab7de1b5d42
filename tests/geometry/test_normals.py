import numpy as np
import pytest
from scipy.spatial import ConvexHull

from unstructured_mg.geometry.normals import face_normals, vertex_normals


def sphere() -> tuple[np.ndarray, np.ndarray]:
    points = np.random.default_rng(1).normal(size=(3000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    faces = ConvexHull(points).simplices.astype(np.int32)
    inward = np.einsum("fx,fx->f", points[faces].mean(1), face_normals(points, faces)) < 0
    faces[inward] = faces[inward][:, ::-1]
    return points, faces


def test_normals_of_a_sphere_point_outwards():
    points, faces = sphere()
    assert np.einsum("nx,nx->n", vertex_normals(points, faces), points).min() > 0.99
    centres = points[faces].mean(1)
    assert (
        np.einsum("fx,fx->f", face_normals(points, faces), centres / np.linalg.norm(centres, axis=1)[:, None]).min()
        > 0.99
    )


def test_vertex_normals_are_the_sums_of_area_times_normal():
    rng = np.random.default_rng(0)
    vertices, faces = rng.normal(size=(40, 3)), rng.integers(0, 40, (90, 3)).astype(np.int32)
    sums = np.zeros((40, 3))
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    for corner in range(3):
        np.add.at(sums, faces[:, corner], np.cross(b - a, c - a))
    expected = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
    np.testing.assert_allclose(vertex_normals(vertices, faces), expected, atol=1e-12)


def test_no_area_no_normal():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]])
    faces = np.array([[0, 1, 2]], np.int32)
    assert not vertex_normals(vertices, faces).any() and not face_normals(vertices, faces).any()
    with pytest.raises(IndexError):
        vertex_normals(vertices, np.array([[0, 1, 4]], np.int32))
