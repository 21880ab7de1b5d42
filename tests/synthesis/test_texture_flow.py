import numpy as np
from textured_pairs import grid

from unstructured_mg.synthesis.texture_flow import uv_changes


def test_an_affine_atlas_moves_as_its_surface_does():
    flat, faces = grid(5, 4, 2.0, 1.0)
    # A plane in space, whose uvs are an affine map of its own two coordinates.
    axes = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0][:2]
    slope = np.array([[0.3, 0.1], [-0.2, 0.4]])
    uv = flat[:, :2] @ slope.T + 0.3
    field = np.random.default_rng(1).normal(size=(len(flat), 2))
    moved = uv_changes(flat[:, :2] @ axes, faces, uv, faces, field @ axes)
    np.testing.assert_allclose(moved, field @ slope.T, atol=1e-12)


def test_charts_move_each_in_their_own_way_and_collapsed_faces_not_at_all():
    vertices, faces = grid(1, 1)
    # The second triangle has a chart of its own, turned by a right angle; a third is collapsed, with a uv of its own.
    turned = vertices[faces[1], :2] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    uv = np.concatenate([vertices[faces[0], :2], turned, [[7.0, 7.0]]])
    face_uv = np.array([[0, 1, 2], [3, 4, 5], [6, 6, 6]])
    faces = np.concatenate([faces, [[0, 0, 1]]])
    moved = uv_changes(vertices, faces, uv, face_uv, np.tile([0.1, 0.0, 0.0], (4, 1)))
    np.testing.assert_allclose(moved, [[0.1, 0]] * 3 + [[0, 0.1]] * 3 + [[0, 0]], atol=1e-12)
