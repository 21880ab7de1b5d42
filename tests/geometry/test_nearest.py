import numpy as np
import pytest
import trimesh

from unstructured_mg.geometry.closest import ClosestPoints
from unstructured_mg.geometry.nearest import NearestPoints


@pytest.fixture(params=[1, 7, 8, 9, 65, 1280], ids=lambda count: f"{count} faces")
def mesh(request):
    """As many faces as fill the tree's eight-wide nodes, or just not; among them one without area."""
    body = trimesh.creation.icosphere(subdivisions=3)
    vertices, faces = np.array(body.vertices) * [1.0, 0.6, 0.3], body.faces[: request.param].astype(np.int32)
    if len(faces) > 1:
        faces[1, 2] = faces[1, 1]
    return vertices, faces


@pytest.fixture
def points():
    return np.random.default_rng(0).normal(size=(500, 3))


def test_distances_are_libigls_and_the_weights_give_the_point_at_that_distance(mesh, points):
    vertices, faces = mesh
    squared, face, weights, _ = NearestPoints(vertices, faces).query(points)
    np.testing.assert_allclose(squared, ClosestPoints(vertices, faces).query(points)[0], rtol=1e-12, atol=1e-18)
    nearest = np.einsum("pi,pix->px", weights, vertices[faces[face]])
    np.testing.assert_allclose(((points - nearest) ** 2).sum(1), squared, rtol=1e-12)
    assert weights.min() >= -1e-15 and np.allclose(weights.sum(1), 1)


def test_guesses_good_bad_or_out_of_range_change_no_distance(mesh, points):
    vertices, faces = mesh
    tree = NearestPoints(vertices, faces)
    squared, _, _, slots = tree.query(points)
    before = slots.copy()
    np.testing.assert_array_equal(tree.query(points, slots)[0], squared)
    np.testing.assert_array_equal(slots, before)
    for bad in (0, len(faces) + 5, -7):
        np.testing.assert_array_equal(tree.query(points, np.full(len(points), bad, np.int32))[0], squared)


def test_the_order_of_another_pose_serves(points):
    body = trimesh.creation.icosphere(subdivisions=3)
    faces = body.faces.astype(np.int32)
    order = NearestPoints(body.vertices, faces).order
    moved = np.array(body.vertices)
    moved[:, 0] += moved[:, 2] ** 2
    np.testing.assert_array_equal(
        NearestPoints(moved, faces, order).query(points)[0], NearestPoints(moved, faces).query(points)[0]
    )


def test_no_points_and_the_farthest_points_are_answered(mesh):
    vertices, faces = mesh
    tree = NearestPoints(vertices, faces)
    assert [len(answer) for answer in tree.query(np.zeros((0, 3)))] == [0, 0, 0, 0]
    squared = tree.query(np.array([[1e6, 0, 0]]))[0]
    np.testing.assert_allclose(np.sqrt(squared), 1e6 - vertices[faces][..., 0].max(), rtol=1e-9)


@pytest.mark.parametrize(
    ("vertices", "faces", "fault"),
    [
        (np.eye(3), np.array([[0, 1, 3]]), "faces: expected indices in 0..2"),
        (np.eye(3), np.zeros((0, 3), int), "m > 0"),
        (np.full((3, 3), np.nan), np.array([[0, 1, 2]]), "finite"),
    ],
)
def test_what_would_crash_is_refused(vertices, faces, fault):
    with pytest.raises(ValueError, match=fault):
        NearestPoints(vertices, faces)


def test_points_and_slots_of_another_shape_are_refused():
    tree = NearestPoints(np.eye(3), np.array([[0, 1, 2]]))
    with pytest.raises(ValueError, match="points"):
        tree.query(np.zeros((4, 2)))
    with pytest.raises(ValueError, match="slots"):
        tree.query(np.zeros((4, 3)), np.zeros(3, np.int32))
