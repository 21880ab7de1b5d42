import numpy as np
import trimesh

from unstructured_mg.geometry.components import face_components, significant_faces, weld


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
