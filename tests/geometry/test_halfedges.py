import numpy as np
import trimesh

from unstructured_mg.geometry.halfedges import match_halfedges, split_fans


def test_a_closed_surface_has_a_neighbour_on_every_side():
    mesh = trimesh.creation.icosphere(subdivisions=2)
    faces = mesh.faces.astype(np.int32)
    neighbor, entry = match_halfedges(np.asarray(mesh.vertices), faces)
    assert (neighbor >= 0).all()
    rows, corner = np.indices(neighbor.shape)
    np.testing.assert_array_equal(neighbor[neighbor, entry], rows)
    np.testing.assert_array_equal(entry[neighbor, entry], corner)
    np.testing.assert_array_equal(faces[rows, (corner + 1) % 3], faces[neighbor, (entry + 2) % 3])
    split, origin = split_fans(faces, neighbor, entry)
    assert len(origin) == len(mesh.vertices)
    np.testing.assert_array_equal(origin[split], faces)


def test_a_surface_stored_front_and_back_becomes_two_sheets():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    front = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    faces = np.concatenate([front, front[:, ::-1]])
    neighbor, entry = match_halfedges(vertices, faces)
    assert sorted(neighbor[neighbor >= 0].tolist()) == [0, 1, 2, 3]
    assert set(neighbor[:2].ravel().tolist()) == {-1, 0, 1}
    split, origin = split_fans(faces, neighbor, entry)
    assert len(origin) == 8 and not set(split[:2].ravel()) & set(split[2:].ravel())


def test_where_three_pages_meet_the_flattest_two_are_neighbours():
    vertices = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 0.1], [-0.2, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 4], [0, 1, 3]], np.int32)
    neighbor, _ = match_halfedges(vertices, faces)
    assert 2 in neighbor[0] and 0 in neighbor[2] and (neighbor[1] == -1).all()


def test_two_cones_that_touch_in_one_vertex_are_taken_apart():
    vertices = np.random.default_rng(0).normal(size=(7, 3))
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [0, 4, 5], [0, 5, 6], [0, 6, 4]], np.int32)
    split, origin = split_fans(faces, *match_halfedges(vertices, faces))
    assert (origin == 0).sum() == 2 and len(origin) == 8
