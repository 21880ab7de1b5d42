import numpy as np

from unstructured_mg.geometry.split_seams import split_seams


def test_every_corner_keeps_its_vertex_and_its_uv():
    random = np.random.default_rng(3)
    faces, face_uv = (random.integers(0, 40, (60, 3)).astype(np.int32) for _ in range(2))
    vertex_index, uv_index, split = split_seams(faces, face_uv)
    np.testing.assert_array_equal(vertex_index[split], faces)
    np.testing.assert_array_equal(uv_index[split], face_uv)
    pairs = set(zip(faces.ravel().tolist(), face_uv.ravel().tolist(), strict=True))
    assert len(vertex_index) == len(pairs) and split.dtype == np.int32


def test_without_uvs_vertices_that_are_used_stay():
    faces = np.array([[5, 2, 9]], np.int32)
    vertex_index, uv_index, split = split_seams(faces, np.zeros((0, 3), np.int32))
    assert vertex_index.tolist() == [2, 5, 9] and len(uv_index) == 0 and split.tolist() == [[1, 0, 2]]
