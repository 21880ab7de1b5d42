"""Atlases: inside the square, apart, nowhere over themselves, nowhere mirrored."""

import igl
import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt, maximum_filter, minimum_filter

from unstructured_mg import _native
from unstructured_mg.capture.procedural import ProceduralCapture
from unstructured_mg.capture.procedural.atlas import GUTTER, STEEPEST, unwrap
from unstructured_mg.capture.procedural.remesh import opposite_half_edges

SIZE = 256


@pytest.fixture(scope="module")
def cuts():
    """A re-meshed body at rest with four atlases, and the faces' neighbours."""
    capture = ProceduralCapture(frames=1, faces=4000, texture_size=64)
    mesh = capture.frame_mesh(0)
    body = capture.body
    resting = np.einsum("pk,pki->pi", mesh.material_weights, body.vertices[body.faces[mesh.material_face]])
    neighbours = (opposite_half_edges(mesh.faces) // 3).reshape(-1, 3)
    density = np.ones(len(mesh.faces))
    return (
        resting,
        mesh.faces,
        neighbours,
        [unwrap(resting, mesh.faces, neighbours, density, SIZE, s) for s in (1, 2, 3, 4)],
    )


def texels(atlas):
    corners = atlas.uv[atlas.face_uv] * SIZE
    return np.stack([corners[..., 0], SIZE - corners[..., 1]], -1)


def doubled_areas(corners):
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def test_all_faces_lie_inside_and_none_is_mirrored(cuts):
    for atlas in cuts[3]:
        corners = atlas.uv[atlas.face_uv]
        assert corners.min() >= 0.4 * GUTTER / SIZE
        assert corners.max() <= 1 - 0.4 * GUTTER / SIZE
        assert (doubled_areas(corners) > 0).all()


def test_no_triangle_lies_over_another(cuts):
    """The area that triangles cover together is the sum of their areas; measured on a grid 12 times finer."""
    fine = 12 * SIZE
    for atlas in cuts[3]:
        corners = texels(atlas) * 12
        owner, weights = np.full((fine, fine), -1, np.int32), np.empty((fine, fine, 3), np.float32)
        _native.raster_charts(np.ascontiguousarray(corners), owner, weights, fine, fine)
        total = 0.5 * np.abs(doubled_areas(corners)).sum()
        assert (owner >= 0).sum() == pytest.approx(total, rel=2e-3)


def test_charts_are_connected_flat_enough_and_two_texels_apart(cuts):
    resting, faces, neighbours, atlases = cuts
    normals = igl.per_face_normals(resting, faces, np.zeros(3))
    for atlas in atlases:
        charts = atlas.chart.max() + 1
        assert 20 <= charts <= 200
        same = atlas.chart[:, None] == atlas.chart[neighbours]
        # As many separate pieces as charts, counted by merging across inner edges.
        piece = np.arange(len(faces))
        for _ in range(200):
            lower = np.minimum(piece, np.where(same, piece[neighbours], piece[:, None]).min(1))
            if (lower == piece).all():
                break
            piece = lower
        assert len(np.unique(piece)) == charts
        image = np.where(atlas.owner >= 0, atlas.chart[atlas.owner], -1)
        high = maximum_filter(image, 5)
        low = minimum_filter(np.where(image < 0, charts, image), 5)
        assert (high[image >= 0] == low[image >= 0]).all()
        # A chart is a projection: no face of it is squeezed beyond the limit.
        corners = atlas.uv[atlas.face_uv]
        squeeze = doubled_areas(corners) / igl.doublearea(resting, faces)
        widest = np.array([squeeze[atlas.chart == c].max() for c in range(charts)])
        assert (squeeze / widest[atlas.chart]).min() > 0.9 * STEEPEST
    assert np.isfinite(normals).all()


def test_seeds_cut_differently(cuts):
    resting, faces, neighbours, (first, second, *_) = cuts
    cut = [atlas.chart[:, None] != atlas.chart[neighbours] for atlas in (first, second)]
    assert (cut[0] & cut[1]).sum() < 0.6 * cut[0].sum()


def test_owner_and_weights_name_the_place_of_each_texel(cuts):
    for atlas in cuts[3]:
        rows, columns = np.nonzero(atlas.owner >= 0)
        assert len(rows) > 0.33 * SIZE * SIZE
        weights = atlas.weights[rows, columns]
        assert weights.min() > -1e-5
        there = np.einsum("pk,pki->pi", weights, texels(atlas)[atlas.owner[rows, columns]])
        assert np.abs(there - np.stack([columns + 0.5, rows + 0.5], 1)).max() < 1e-3


def test_raster_against_brute_force():
    draw = np.random.default_rng(11)
    corners = draw.uniform(-2, 22, (40, 3, 2))
    owner, weights = np.full((20, 18), -1, np.int32), np.zeros((20, 18, 3), np.float32)
    _native.raster_charts(corners, owner, weights, 18, 20)
    clash, taken = np.zeros(40, np.uint8), np.zeros((20, 18), np.uint8)
    _native.find_overlaps(corners, taken, clash, 18, 20)
    centres = np.stack(np.meshgrid(np.arange(18) + 0.5, np.arange(20) + 0.5), -1).reshape(-1, 2)
    inside = np.zeros((40, len(centres)))
    for f, (a, b, c) in enumerate(corners):
        solved = np.linalg.solve(np.stack([b - a, c - a], 1), (centres - a).T)
        inside[f] = np.minimum(np.minimum(solved[0], solved[1]), 1 - solved.sum(0))
    first = np.where((inside >= 0).any(0), (inside >= 0).argmax(0), -1)
    assert (owner.ravel() == first).all()
    accepted = np.zeros(len(centres), bool)
    for f in range(40):
        covers = inside[f] >= 1e-3
        assert clash[f] == (covers & accepted).any()
        if not clash[f]:
            accepted |= covers


def test_spread_fills_with_nearly_the_nearest_texel():
    draw = np.random.default_rng(12)
    covered = draw.random((60, 70)) < 0.01
    source = np.where(covered, np.arange(60 * 70).reshape(60, 70), -1).astype(np.int32)
    _native.spread_texels(source, 70, 60)
    assert covered.ravel()[source.ravel()].all()
    rows, columns = np.indices((60, 70))
    distance = np.hypot(source // 70 - rows, source % 70 - columns)
    exact = distance_transform_edt(~covered)
    assert (distance >= exact - 1e-9).all()
    assert (distance <= exact + 1.0).all()
    assert np.mean(distance > exact + 1e-9) < 0.01
