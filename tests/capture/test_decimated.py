import numpy as np
from memory_capture import box

from unstructured_mg.capture.decimated import decimated_mesh
from unstructured_mg.capture.mesh import TexturedMesh


def test_nothing_is_done_where_there_is_nothing_to_do():
    mesh = box((1, 2, 3))
    assert decimated_mesh(mesh, 12) is mesh


def test_colours_and_materials_stay_with_what_is_left():
    n = 21
    y, x = np.mgrid[:n, :n].reshape(2, -1)
    i = np.arange(n * (n - 1)).reshape(n - 1, n)[:, :-1].ravel()
    faces = np.concatenate([np.stack([i, i + 1, i + n + 1], 1), np.stack([i, i + n + 1, i + n], 1)]).astype(np.int32)
    vertices = np.stack([x, y, np.sin(x / 3.0)], 1)
    material = (x[faces].mean(axis=1) > 10).astype(np.int32)
    colors = np.stack([x, y, x + y], 1).astype(np.uint8)
    mesh = TexturedMesh(vertices, faces, vertices[:, :2] / 20, faces.copy(), colors, (), material)
    small = decimated_mesh(mesh, 60)
    assert len(small.faces) <= 60 and 0 < small.face_material.sum() < 60
    np.testing.assert_array_equal(small.colors[:, :2], small.vertices[:, :2])
    np.testing.assert_array_equal(small.uv[small.face_uv], small.vertices[small.faces][..., :2] / 20)
    np.testing.assert_array_equal(small.face_material, small.vertices[small.faces][..., 0].mean(axis=1) > 10)
