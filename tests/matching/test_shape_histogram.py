import numpy as np
import pytest
import trimesh
from array_capture import array_capture, figure

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import UserError
from unstructured_mg.matching import shape_histogram
from unstructured_mg.matching.dissimilarity import compute_dissimilarity
from unstructured_mg.matching.extent import extent
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.matching.shape_histogram import FINE, RADII, TILTS, TURNS, describe, fit, volume_histogram


def coarse(histogram, shift=0):
    """H's bins of the turn, after a shift by so many fine samples: FINE is cut so that TURNS bins divide it."""
    fine = np.repeat(histogram, TURNS, axis=2) / TURNS
    return np.roll(fine, shift, axis=2).reshape(RADII, TILTS, TURNS, -1).sum(axis=3)


def bent_tube():
    """A closed surface whose centre lies outside it: rays enter and leave it again."""
    torus = trimesh.creation.torus(0.6, 0.15, major_sections=96, minor_sections=48)
    return torus.vertices + [0.25, 0.1, 0.0], torus.faces


def test_is_the_share_of_voxels_inside_by_cell():
    """The paper's own way: voxels, tested one by one for being inside, counted by spherical coordinates."""
    vertices, faces = bent_tube()
    histogram = volume_histogram(vertices, faces, 1.2)
    size = 0.015
    axis = np.arange(-1.2 + size / 2, 1.2, size)
    voxels = np.stack(np.meshgrid(axis, axis, axis[np.abs(axis) < 0.2], indexing="ij"), axis=-1).reshape(-1, 3)
    ring = np.hypot(voxels[:, 0] - 0.25, voxels[:, 1] - 0.1) - 0.6
    voxels = voxels[np.hypot(ring, voxels[:, 2]) < 0.15]
    radius = np.linalg.norm(voxels, axis=1)
    cells = (
        (radius / 1.2 * RADII).astype(int),
        (np.arccos(voxels[:, 2] / radius) / np.pi * TILTS).astype(int),
        np.floor(np.arctan2(voxels[:, 1], voxels[:, 0]) / (2 * np.pi) * TURNS).astype(int) % TURNS,
    )
    counted = np.zeros((RADII, TILTS, TURNS))
    np.add.at(counted, cells, 1 / len(voxels))
    found = coarse(histogram)
    assert found.sum() == pytest.approx(1)
    assert np.abs(found - counted).sum() < 0.05  # the voxels' own error; 0.03 at half their size
    assert counted.max() > 0.005


def test_a_ball_about_the_origin_fills_its_shells_evenly():
    ball = trimesh.creation.icosphere(5, radius=0.45)
    histogram = volume_histogram(ball.vertices, ball.faces, 1.0)
    edges = np.minimum(np.arange(RADII + 1) / RADII, 0.45)
    np.testing.assert_allclose(histogram.sum(axis=(1, 2)), np.diff(edges**3) / 0.45**3, atol=3e-3)
    np.testing.assert_allclose(histogram.sum(axis=(0, 1)).reshape(16, -1).sum(axis=1), 1 / 16, atol=2e-3)


def test_scores_are_the_papers_averaged_over_how_the_bins_lie():
    frames = [figure(0.4, seed=1), figure(1.9, 0.7, seed=2)]
    capture = array_capture(frames)
    extents = np.stack([extent(TexturedMesh(*frame)) for frame in frames])
    cells = fit(capture, extents, 64)
    histograms = [
        volume_histogram(vertices - [*place[:2], cells.height], faces, cells.radius)
        for (vertices, faces), place in zip(frames, extents, strict=True)
    ]
    (first, own_first), (second, own_second) = (describe(capture, i, extents[i], cells) for i in (0, 1))
    products = (first[:64] * second[64:] + (second[:64] * first[64:]).conj()).sum(axis=1) / 2
    step = 40  # fine samples of the FINE * TURNS that `coarse` shifts by
    for turn in (17, 700):
        yaw = turn * step * 2 * np.pi / (FINE * TURNS)
        value = np.real(products * np.exp(1j * np.arange(64) * yaw))
        found = (value[0] + 2 * value[1:].sum()) / 128 - (own_first + own_second) / 2
        expected = np.mean(
            [
                ((coarse(histograms[0], lie) - coarse(histograms[1], lie + turn * step)) ** 2).sum()
                for lie in range(0, FINE, 256)
            ]
        )
        assert found == pytest.approx(expected, rel=0.01)


def test_yaw_is_found_within_a_degree_on_other_meshes(tmp_path):
    turns = np.random.default_rng(3).uniform(-np.pi, np.pi, 6)
    meshes, clips = [figure(0.3 * i, seed=i) for i in range(5)], [("source", range(5))]
    for number, turn in enumerate(turns):
        meshes += [figure(0.3 * i, -turn, (0.3, 1.0, 0.0), seed=50 + 7 * i + number) for i in range(5)]
        clips.append((f"turned {number}", range(5)))
    options = MatchingOptions(descriptor="shape_histogram", k=2)
    found = compute_dissimilarity(array_capture(meshes, clips=clips), options, scratch=tmp_path)
    centres = 5 * np.arange(1, 7) + 2
    error = np.degrees(np.abs((found.yaw[2, centres] - turns + np.pi) % (2 * np.pi) - np.pi))
    assert error.max() < 0.5
    assert found.scores[2, centres].max() < 0.25 * shape_histogram.DESCRIPTOR.threshold
    assert found.unit == ""


def test_a_surface_that_encloses_nothing_is_refused(tmp_path):
    vertices, faces = figure(0.0, seed=1)
    sheet = (vertices, np.concatenate([faces, faces[:, ::-1]]))
    capture = array_capture([figure(0.0), sheet, figure(0.0)])
    options = MatchingOptions(descriptor="shape_histogram", k=1)
    with pytest.raises(UserError, match=r"clip/1\.obj: encloses no volume.*--descriptor cylindrical_edt"):
        compute_dissimilarity(capture, options, scratch=tmp_path)
    assert list(tmp_path.iterdir()) == []
