import numpy as np
import pytest
import scipy.sparse as sp
import trimesh
from scipy.sparse.csgraph import connected_components

from unstructured_mg.geometry.components import compact, face_components, significant_faces, weld, weld_labels


def test_weld_joins_a_box_cut_into_six_sides():
    box = trimesh.creation.box()
    triangles = box.triangles.reshape(-1, 3)
    faces = np.arange(36, dtype=np.int32).reshape(12, 3)
    assert face_components(36, faces).max() == 11
    vertices, welded, index = weld(triangles, faces)
    assert len(vertices) == 8 and face_components(8, welded).max() == 0
    np.testing.assert_array_equal(vertices[index], triangles)


def test_debris_is_not_significant():
    ball, crumb = trimesh.creation.icosphere(), trimesh.creation.icosphere(radius=0.05)
    vertices = np.vstack([ball.vertices, crumb.vertices + 3])
    faces = np.vstack([ball.faces, crumb.faces + len(ball.vertices)])
    kept = significant_faces(vertices, faces)
    assert kept[: len(ball.faces)].all() and not kept[len(ball.faces) :].any()


def test_weld_labels_are_those_of_a_dictionary():
    rng = np.random.default_rng(0)
    for count in (0, 1, 2, 17, 5000):
        rows = rng.integers(-6, 6, (count, 3)) * 0.1
        rows[rng.random((count, 3)) < 0.1] *= -0.0  # minus zero equals zero
        labels, different = weld_labels(rows)
        seen = {}
        expected = [seen.setdefault(tuple(row + 0.0), len(seen)) for row in rows]
        np.testing.assert_array_equal(labels, expected)
        assert different == len(seen)


def test_face_components_are_those_of_a_graph_search():
    rng = np.random.default_rng(1)
    for vertex_count, face_count in ((3, 1), (50, 12), (1000, 300), (1000, 700), (5000, 4000)):
        faces = rng.integers(0, vertex_count, (face_count, 3)).astype(np.int32)
        ends = np.concatenate([faces[:, :2], faces[:, 1:]])
        graph = sp.coo_matrix((np.ones(len(ends)), ends.T), (vertex_count, vertex_count))
        _, labels = connected_components(graph, directed=False)
        _, expected = np.unique(labels[faces[:, 0]], return_inverse=True)
        np.testing.assert_array_equal(face_components(vertex_count, faces), expected.reshape(-1))


def test_an_index_out_of_range_is_an_error_and_no_crash():
    for index in (-1, 4, 2**31 - 1):
        with pytest.raises(ValueError, match="faces"):
            face_components(4, np.array([[0, 1, index]], np.int32))


def test_compact_leaves_out_what_no_face_names():
    vertices = np.arange(18.0).reshape(6, 3)
    kept, faces, indices = compact(vertices, np.array([[5, 1, 3], [3, 1, 5]], np.int32))
    np.testing.assert_array_equal(kept, vertices[[1, 3, 5]])
    np.testing.assert_array_equal(faces, [[2, 0, 1], [1, 0, 2]])
    np.testing.assert_array_equal(indices, [1, 3, 5])
