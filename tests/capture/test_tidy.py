from pathlib import Path

import numpy as np
import trimesh

from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.texture import Texture
from unstructured_mg.capture.tidy import Tidied, tidy

UNCHANGED = Tidied(0, 0, 0, 0, 0, 0)


def raw_mesh(vertices, faces, uv=None, face_uv=None, **more):
    faces = np.asarray(faces, np.int32)
    uv = np.zeros((0, 2)) if uv is None else np.asarray(uv, np.float64)
    face_uv = np.full(faces.shape, -1, np.int32) if face_uv is None else np.asarray(face_uv, np.int32)
    return RawMesh(np.asarray(vertices, np.float64), faces, uv, face_uv, **more)


def ball():
    sphere = trimesh.creation.icosphere(subdivisions=2)
    return np.array(sphere.vertices), np.array(sphere.faces, np.int32)


def split(vertices, faces, label):
    """Every group of faces gets vertices of its own: the split vertices, faces, and each vertex's original."""
    keys = label[:, None].astype(np.int64) * len(vertices) + faces
    unique, inverse = np.unique(keys, return_inverse=True)
    return vertices[unique % len(vertices)], inverse.reshape(-1, 3).astype(np.int32), unique % len(vertices)


def test_a_sound_mesh_stays_as_the_file_has_it():
    vertices, faces = ball()
    uv = np.random.default_rng(0).random((len(vertices), 2))
    mesh, tidied = tidy(raw_mesh(vertices, faces, uv, faces))
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.faces, faces)
    np.testing.assert_array_equal(mesh.uv, uv)
    np.testing.assert_array_equal(mesh.face_uv, faces)
    assert tidied == UNCHANGED and mesh.faces.dtype == mesh.face_uv.dtype == np.int32
    assert mesh.textures == () and mesh.face_material is None


def test_split_seams_become_one_vertex_with_two_uvs():
    vertices, faces = ball()
    chart = (vertices[faces].mean(axis=1) @ [1.0, 2.0, 0.5] > 0).astype(int)
    split_vertices, split_faces, _ = split(vertices, faces, chart)
    uv = split_vertices[:, :2] + 3.0 * np.arange(len(split_vertices))[:, None]
    mesh, tidied = tidy(raw_mesh(split_vertices, split_faces, uv, split_faces))
    assert len(mesh.vertices) == len(vertices) and tidied.welded == len(split_vertices) - len(vertices)
    assert trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).is_watertight
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], split_vertices[split_faces])
    np.testing.assert_array_equal(mesh.uv[mesh.face_uv], uv[split_faces])
    assert len(mesh.uv) == len(uv)


def test_a_soup_of_corners_becomes_a_surface_and_an_atlas():
    vertices, faces = ball()
    chart = (vertices[faces].mean(axis=1)[:, 0] > 0).astype(int)
    split_vertices, split_faces, _ = split(vertices, faces, chart)
    uv = split_vertices[:, 1:] + np.array([[0.0, 9.0]])
    uv[split_vertices[:, 0] > 0] += 50.0
    corners = np.arange(3 * len(faces)).reshape(-1, 3)
    mesh, _ = tidy(
        raw_mesh(split_vertices[split_faces].reshape(-1, 3), corners, uv[split_faces].reshape(-1, 2), corners)
    )
    assert len(mesh.vertices) == len(vertices) and len(mesh.uv) <= len(split_vertices)
    np.testing.assert_array_equal(mesh.vertices[mesh.faces], split_vertices[split_faces])
    np.testing.assert_array_equal(mesh.uv[mesh.face_uv], uv[split_faces])


def test_vertices_that_chance_to_meet_inside_a_closed_surface_stay_two():
    vertices, faces = ball()
    both = np.vstack([vertices, vertices + [1.0, 0.0, 0.0]])
    both[len(vertices) + 5] = both[7]
    mesh, tidied = tidy(raw_mesh(both, np.vstack([faces, faces + len(vertices)])))
    assert len(mesh.vertices) == len(both) and tidied == UNCHANGED


def test_faces_with_a_repeated_corner_go_and_flat_ones_stay():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [9, 9, 9]]
    mesh, tidied = tidy(raw_mesh(vertices, [[0, 1, 2], [0, 1, 1], [0, 3, 1], [2, 2, 2]]))
    np.testing.assert_array_equal(mesh.faces, [[0, 1, 2], [0, 3, 1]])
    assert tidied == Tidied(0, 2, 0, 0, 1, 0) and len(mesh.vertices) == 4


def test_a_front_and_a_back_become_one_surface_and_a_single_fold_stays():
    vertices, faces = ball()
    mesh, tidied = tidy(raw_mesh(vertices, np.vstack([faces, faces[:, ::-1], faces[:9, [1, 2, 0]]])))
    np.testing.assert_array_equal(mesh.faces, faces)
    assert tidied == Tidied(0, 0, len(faces) + 9, 0, 0, 0)
    # the back may have vertices of its own, as where it has normals of its own
    mesh, tidied = tidy(raw_mesh(np.vstack([vertices, vertices]), np.vstack([faces, faces[:, ::-1] + len(vertices)])))
    np.testing.assert_array_equal(mesh.vertices, vertices)
    np.testing.assert_array_equal(mesh.faces, faces)
    assert tidied == Tidied(len(vertices), 0, len(faces), 0, 0, 0)
    mesh, tidied = tidy(raw_mesh(vertices, np.vstack([faces, faces[:4, ::-1]])))
    assert len(mesh.faces) == len(faces) + 4 and tidied == Tidied(0, 0, 0, 4, 0, 0)


def test_faces_without_uv_or_image_get_the_corner_of_the_first_image():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    images = (Texture(Path("a.png")), Texture(Path("b.png")))
    mesh, tidied = tidy(
        raw_mesh(
            vertices,
            [[0, 1, 2], [1, 3, 2], [0, 3, 1]],
            [[0.1, 0.2], [0.9, 0.2], [0.1, 0.8]],
            [[0, 1, 2], [1, -1, 2], [0, 1, 2]],
            images=images,
            face_image=np.array([1, 1, -1], np.int32),
        )
    )
    np.testing.assert_array_equal(mesh.uv[mesh.face_uv[0]], [[0.1, 0.2], [0.9, 0.2], [0.1, 0.8]])
    np.testing.assert_array_equal(mesh.uv[mesh.face_uv[1:]], np.zeros((2, 3, 2)))
    np.testing.assert_array_equal(mesh.face_material, [1, 1, 0])
    assert tidied.untextured == 2 and mesh.textures == images


def test_colours_follow_their_vertices():
    colors = np.arange(15, dtype=np.uint8).reshape(5, 3)
    mesh, _ = tidy(raw_mesh(np.eye(5, 3), [[0, 2, 4]], colors=colors))
    np.testing.assert_array_equal(mesh.colors, colors[[0, 2, 4]])
