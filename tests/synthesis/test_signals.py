import numpy as np
import scipy.sparse as sp
from textured_pairs import grid, tube

from unstructured_mg.geometry.laplacian import mass_matrix, stiffness_matrix
from unstructured_mg.synthesis.flow_surface import build_flow_surface
from unstructured_mg.synthesis.signals import fill_harmonic, vertex_signals
from unstructured_mg.synthesis.texels import at_texels, locate_texels


def test_means_of_a_smooth_signal_are_the_signal():
    vertices, faces, uv, face_uv = tube(24, 16)
    surface = build_flow_surface(vertices, faces, uv[face_uv], 0.05)
    texels = locate_texels(surface, 256, 256, 2)
    truth = surface.vertices * [100, 100, 20] + 50
    colors = at_texels(surface, texels, truth)
    signals, known = vertex_signals(surface, texels, colors, np.ones(len(colors), bool))
    rim = (surface.vertices[:, 2] < 1e-9) | (surface.vertices[:, 2] > 1 - 1e-9)
    assert known.all()
    np.testing.assert_allclose(signals[~rim], truth[~rim], atol=0.3)
    _, known = vertex_signals(surface, texels, colors, colors[:, 2] > 60)
    assert not known[surface.vertices[:, 2] < 0.4].any() and known[surface.vertices[:, 2] > 0.6].all()


def test_holes_are_filled_harmonically():
    vertices, faces = grid(12, 12)
    stiffness, masses = stiffness_matrix(vertices, faces).tocsr(), mass_matrix(vertices, faces).diagonal()
    truth = np.stack([50 + 100 * vertices[:, 0], 200 - 30 * vertices[:, 1]], axis=1)
    known = np.abs(vertices[:, :2] - 0.5).max(axis=1) > 0.3
    filled = fill_harmonic(stiffness, masses, np.where(known[:, None], truth, 0), known)
    np.testing.assert_allclose(filled, truth, atol=1e-2)
    np.testing.assert_array_equal(filled[known], truth[known])


def test_parts_that_touch_nothing_known_take_the_mean():
    stiffness = sp.block_diag([np.array([[1, -1], [-1, 1.0]])] * 2).tocsr()
    signals, known = np.array([[10.0], [30], [0], [0]]), np.array([True, True, False, False])
    np.testing.assert_allclose(fill_harmonic(stiffness, np.ones(4), signals, known), [[10], [30], [20], [20]])
    assert (fill_harmonic(stiffness, np.ones(4), signals, np.zeros(4, bool)) == 127.5).all()
