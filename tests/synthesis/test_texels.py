import numpy as np
from textured_pairs import grid, tube

from unstructured_mg.synthesis.flow_surface import build_flow_surface
from unstructured_mg.synthesis.texels import at_texels, cover_texels, locate_texels, to_pixels, unbroken


def reference_cover(places, height, width):
    """Every texel centre against every triangle, the first one inside wins."""
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    owner = np.full((height, width), -1)
    for f, (a, b, c) in reversed(list(enumerate(places))):
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if abs(area) < 1e-9:
            continue
        b1 = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
        b2 = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
        owner[(b1 >= 0) & (b2 >= 0) & (b1 + b2 <= 1)] = f
    return owner


def test_cover_agrees_with_brute_force():
    generator = np.random.default_rng(0)
    places = generator.uniform(-5, 45, (30, 3, 2))
    places[3, 2] = places[3, 1]
    owner, weights, twice = cover_texels(places, 30, 40)
    np.testing.assert_array_equal(owner, reference_cover(places, 30, 40))
    row, column = np.nonzero(owner >= 0)
    b1, b2 = weights[row, column].T.astype(float)
    corners = places[owner[row, column]]
    centre = (1 - b1 - b2)[:, None] * corners[:, 0] + b1[:, None] * corners[:, 1] + b2[:, None] * corners[:, 2]
    np.testing.assert_allclose(centre, np.column_stack([column, row]) + 0.5, atol=2e-4)
    assert twice > 0


def test_triangles_that_only_share_edges_do_not_overlap():
    _, _, uv, face_uv = tube(16, 10)
    owner, _, twice = cover_texels(to_pixels(uv[face_uv], 100, 120), 100, 120)
    assert twice == 0 and (owner >= 0).sum() == 90 * 108


def test_texels_of_the_margin_lie_across_the_seam():
    vertices, faces, uv, face_uv = tube(64, 40)
    surface = build_flow_surface(vertices, faces, uv[face_uv], 1.0)
    texels = locate_texels(surface, 200, 200, 4)
    points = at_texels(surface, texels, surface.vertices)
    row, column = texels.index // 200, texels.index % 200
    angle = 2 * np.pi * ((column + 0.5) / 200 - 0.05) / 0.9
    # Beside the chart the tube goes on around; above and below it ends.
    beside = (row >= 10) & (row < 190)
    assert (beside & ~texels.inside).sum() == 2 * 4 * 180
    truth = 0.15 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert np.abs(points[beside, :2] - truth[beside]).max() < 5e-4
    height = (1 - (row + 0.5) / 200 - 0.05) / 0.9
    np.testing.assert_allclose(points[:, 2], height.clip(0, 1), atol=1e-6)


def test_texels_beside_another_chart_are_broken_off():
    """Both halves of a square, swapped in the atlas: they touch in the image where they do not on the surface."""
    vertices, faces = grid(8, 4)
    uv = vertices[faces][:, :, :2].copy()
    left = uv[:, :, 0].mean(axis=1) < 0.5
    uv[:, :, 0] += np.where(left, 0.5, -0.5)[:, None]
    surface = build_flow_surface(vertices, faces, uv, 0.05)
    whole = unbroken(surface, locate_texels(surface, 32, 64, 4))
    expected = np.ones((32, 64), bool)
    expected[[0, -1]] = expected[:, [0, 31, 32, 63]] = False
    np.testing.assert_array_equal(whole, expected)
