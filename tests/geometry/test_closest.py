import numpy as np
import pytest
import trimesh

from unstructured_mg.geometry.closest import ClosestPoints


def test_distances_and_weights_on_a_sphere_agree_with_brute_force():
    mesh = trimesh.creation.icosphere(subdivisions=2)
    tree = ClosestPoints(mesh.vertices, mesh.faces)
    points = np.random.default_rng(0).normal(size=(60, 3)) * 2
    squared, face, closest = tree.query(points)

    count = len(mesh.faces)
    repeated = np.repeat(points, count, axis=0)
    on_each = trimesh.triangles.closest_point(np.tile(mesh.triangles, (60, 1, 1)), repeated)
    brute = ((on_each - repeated) ** 2).sum(1).reshape(60, count).min(1)
    np.testing.assert_allclose(squared, brute, rtol=1e-9)

    weights = tree.barycentric(face, closest)
    rebuilt = np.einsum("pi,pij->pj", weights, mesh.vertices[mesh.faces[face]])
    np.testing.assert_allclose(rebuilt, closest, atol=1e-9)
    np.testing.assert_allclose(weights.sum(1), 1)


def test_faces_out_of_range_are_refused_before_native_code():
    with pytest.raises(ValueError, match="faces: expected indices in 0..2"):
        ClosestPoints(np.eye(3), np.array([[0, 1, 3]]))
    with pytest.raises(ValueError, match="m > 0"):
        ClosestPoints(np.eye(3), np.zeros((0, 3), int))
