import numpy as np
import pytest
from textured_pairs import tube

from unstructured_mg.synthesis.flow_surface import build_flow_surface


def test_split_seams_are_welded_and_uvs_stay_with_their_corners():
    vertices, faces, uv, face_uv = tube(16, 10)
    whole = build_flow_surface(vertices, faces, uv[face_uv], 1.0)
    # One vertex a uv, as many exporters write it: the same surface must come of it.
    split_vertices = np.zeros((len(uv), 3))
    split_vertices[face_uv] = vertices[faces]
    split = build_flow_surface(split_vertices, face_uv, uv[face_uv], 1.0)
    np.testing.assert_allclose(split.vertices, whole.vertices)
    np.testing.assert_array_equal(split.tracing.faces, whole.tracing.faces)
    np.testing.assert_allclose(split.uv, whole.uv)
    # Only the tube's two ends are boundary.
    assert (whole.tracing.neighbor < 0).sum() == 2 * 16
    np.testing.assert_allclose(split.vertices[split.vertex_of], split_vertices)


def test_positions_of_any_frame_are_lifted_linearly():
    vertices, faces, uv, face_uv = tube(16, 10)
    surface = build_flow_surface(vertices, faces, uv[face_uv], 0.03)
    assert len(surface.vertices) > 2 * len(vertices)
    moved = vertices @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 2.0]]) + 5
    np.testing.assert_allclose(
        surface.lift @ moved, surface.vertices @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 2.0]]) + 5
    )


def test_collapsed_faces_are_left_out_and_nothing_but_collapsed_faces_is_refused():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0.0]])
    faces = np.array([[0, 1, 2], [1, 3, 2], [2, 3, 3]], np.int32)
    surface = build_flow_surface(vertices, faces, np.zeros((3, 3, 2)), 2.0)
    assert len(surface.tracing.faces) == 1
    with pytest.raises(ValueError, match="three different corners"):
        build_flow_surface(vertices, faces[1:], np.zeros((2, 3, 2)), 2.0)
