import numpy as np
import pytest
from tracking.bodies import tube

from unstructured_mg.geometry.normals import vertex_normals
from unstructured_mg.tracking.surface import clean_surface, face_normals, vertex_areas


def test_seams_are_welded_debris_dropped_and_defects_marked():
    vertices, faces = tube(0.2, 1.0, 40, 20)
    soup = vertices[faces].reshape(-1, 3)
    soup_faces = np.arange(len(soup), dtype=np.int32).reshape(-1, 3)
    crumb = np.array([[3, 0, 0], [3.01, 0, 0], [3, 0.01, 0]])
    flat = np.array([[0, 3, 0]] * 3) * 0 + vertices[faces[0, 0]]
    everything = np.concatenate([soup, crumb, flat])
    extra = len(soup) + np.array([[0, 1, 2], [3, 4, 5]], np.int32)
    repeat = soup_faces[:7, ::-1]
    surface = clean_surface(everything, np.concatenate([soup_faces, extra, repeat]).astype(np.int32))
    assert len(surface.vertices) == len(vertices)
    assert surface.geometric.sum() == len(faces)
    np.testing.assert_array_equal(np.flatnonzero(~surface.geometric), len(faces) + np.arange(7))
    np.testing.assert_array_equal(surface.face_index, np.r_[: len(faces), len(faces) + 2 + np.arange(7)])
    np.testing.assert_allclose(
        face_normals(surface.vertices, surface.faces[surface.geometric]), face_normals(vertices, faces), atol=1e-12
    )


def test_normals_point_away_from_a_tubes_axis_and_areas_add_up():
    vertices, faces = tube(0.2, 1.0, 80, 30)
    side = np.abs(vertices[:, 0]) < 0.4
    radial = vertices[side] * [0, 1, 1] / 0.2
    assert np.einsum("ix,ix->i", vertex_normals(vertices, faces)[side], radial).min() > 0.999
    np.testing.assert_allclose(vertex_areas(vertices, faces).sum(), 2 * np.pi * 0.2 + 4 * np.pi * 0.2**2, rtol=0.02)


@pytest.mark.parametrize(
    ("vertices", "faces", "name"),
    [
        (np.zeros((3, 2)), np.array([[0, 1, 2]]), "vertices"),
        (np.array([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]), "vertices"),
        (np.eye(3), np.zeros((0, 3), int), "faces"),
        (np.eye(3), np.array([[0, 1, 3]]), "faces"),
        (np.eye(3), np.array([[0.0, 1.0, 2.0]]), "faces"),
        (np.eye(3), np.array([[0, 1, 1]]), "faces"),
    ],
)
def test_what_is_no_surface_is_named(vertices, faces, name):
    with pytest.raises(ValueError, match=name):
        clean_surface(vertices, faces)
