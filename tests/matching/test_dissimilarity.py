from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from array_capture import array_capture, figure
from real_captures import real_capture

from unstructured_mg.capture.reader import open_capture
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.matching import correlation, cylindrical_edt, dissimilarity, fields
from unstructured_mg.matching.dissimilarity import compute_dissimilarity
from unstructured_mg.matching.extent import extent
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.matching.velocity import root_velocities
from unstructured_mg.matching.window import spline_weights

QUICK = MatchingOptions(resolution=32, k=2)


def turned_walk(count, seed):
    """Frames of a walk in place, each turned and shifted at random but smoothly enough for a window."""
    rng = np.random.default_rng(seed)
    return [
        figure(0.5 * i, 0.1 * i + seed, (0.05 * i, rng.random() / 50, 0), seed=100 * seed + i) for i in range(count)
    ]


@pytest.fixture(scope="module")
def walk():
    return array_capture(turned_walk(14, 1))


@pytest.fixture(scope="module")
def walk_result(walk, tmp_path_factory):
    return compute_dissimilarity(walk, QUICK, scratch=tmp_path_factory.mktemp("scratch"))


def test_equals_the_definition_summed_directly(walk, walk_result):
    """Window sums of correlations over rolled grids, evaluated between grid yaws by trigonometric interpolation."""
    extents = np.stack([extent(walk.read(i)) for i in range(14)])
    cylinder = cylindrical_edt.fit(walk, extents, 32)
    grids = [
        cylindrical_edt.sample(mesh.vertices - [*place[:2], 0], mesh.faces, cylinder)
        for mesh, place in ((walk.read(i), extents[i]) for i in range(14))
    ]
    grids = [(x.astype(float), e.astype(float)) for x, e, _ in grids]

    def rolled(s, t):
        return np.array(
            [
                (
                    (grids[s][0] * np.roll(grids[t][1], turn, 2)).sum()
                    + (grids[s][1] * np.roll(grids[t][0], turn, 2)).sum()
                )
                / 2
                for turn in range(64)
            ]
        )

    weights = spline_weights(2)
    velocities = root_velocities(extents[:, :2], weights, 30.0)
    dense = np.arange(64 * 20) * 2 * np.pi / (64 * 20)
    for s, t in ((2, 2), (2, 7), (5, 11), (9, 10)):
        terms = zip(weights, range(-2, 3), strict=True)
        values = sum(
            w * (rolled(s + l, t + l) - (rolled(s + l, s + l)[0] + rolled(t + l, t + l)[0]) / 2) for w, l in terms
        )
        between = np.fft.irfft(np.fft.rfft(values)[:32], 64 * 20) * 20
        between = between + 0.01 * np.abs(velocities[s] - np.exp(1j * dense) * velocities[t]) ** 2
        best = np.argmin(between)
        assert walk_result.scores[s, t] ** 2 == pytest.approx(max(between[best], 0), abs=1e-6)
        turn = walk_result.yaw[s, t] - dense[best]
        assert abs((turn + np.pi) % (2 * np.pi) - np.pi) <= np.pi / (64 * 20) + 1e-3


def test_is_a_symmetric_matrix_with_an_antisymmetric_yaw(walk_result):
    scores, yaw = walk_result.scores, walk_result.yaw
    inside = slice(2, 12)
    assert np.isfinite(scores[inside, inside]).all() and np.isfinite(yaw[inside, inside]).all()
    outside = np.ones((14, 14), bool)
    outside[inside, inside] = False
    assert np.isnan(scores[outside]).all() and np.isnan(yaw[outside]).all()
    np.testing.assert_array_equal(scores, scores.T)
    np.testing.assert_array_equal(yaw, -yaw.T)
    assert (np.diagonal(scores)[inside] == 0).all()


def test_yaw_is_found_within_a_degree_between_grid_angles_on_other_meshes(tmp_path):
    """The same motion twice, re-meshed and turned: rotating the target by +yaw must bring it onto the source."""
    rng = np.random.default_rng(3)
    turns = rng.uniform(-np.pi, np.pi, 12)
    first = [figure(0.3 * i, seed=i) for i in range(5)]
    clips, meshes = [("source", range(5))], list(first)
    for number, turn in enumerate(turns):
        motion = PlanarRigid(turn, *rng.normal(size=2)).inverse()
        meshes += [
            (motion.apply(vertices), faces)
            for vertices, faces in (figure(0.3 * i, seed=50 + 7 * i + number) for i in range(5))
        ]
        clips.append((f"turned {number}", range(5)))
    found = compute_dissimilarity(array_capture(meshes, clips=clips), QUICK, scratch=tmp_path)
    centres = 5 * np.arange(1, 13) + 2
    error = np.degrees(np.abs((found.yaw[2, centres] - turns + np.pi) % (2 * np.pi) - np.pi))
    assert error.max() < 0.2
    assert found.scores[2, centres].max() < 2e-3


def test_neighbours_differ_by_their_motion_and_not_by_the_grid(tmp_path):
    """Slow motion: the score of frames l apart grows with l, from little at once and not from a grid's 10 mm."""
    capture = array_capture([figure(0.02 * i, seed=i) for i in range(24)])
    scores = compute_dissimilarity(capture, MatchingOptions(k=2), scratch=tmp_path).scores
    means = [np.nanmean(np.diagonal(scores, lag)) for lag in (2, 4, 8, 16)]
    np.testing.assert_allclose(means, means[3] * np.array([1, 2, 4, 8]) / 8, rtol=0.25)
    assert means[0] < 5e-3


def test_a_jump_does_not_match_a_stand(tmp_path):
    meshes = [figure(0.0, seed=i) for i in range(5)] + [
        figure(0.0, position=(0, 0, 0.3), seed=10 + i) for i in range(5)
    ]
    capture = array_capture(meshes, clips=[("stand", range(5)), ("jump", range(5))])
    assert compute_dissimilarity(capture, QUICK, scratch=tmp_path).scores[2, 7] > 0.05


def test_walking_on_the_spot_does_not_match_walking(tmp_path):
    step = 1.4 / 30
    spot = [figure(0.2 * i, seed=i) for i in range(7)]
    walking = [figure(0.2 * i, position=(step * i, 0, 0), seed=20 + i) for i in range(7)]
    turned = [figure(0.2 * i, 2.0, (step * i * np.cos(2), step * i * np.sin(2), 0), seed=40 + i) for i in range(7)]
    clips = [(name, range(7)) for name in ("spot", "walking", "turned")]
    capture = array_capture(spot + walking + turned, clips=clips)
    with_root = compute_dissimilarity(capture, MatchingOptions(k=3, resolution=32), scratch=tmp_path)
    assert with_root.scores[3, 10] > 0.1 > 0.04 * with_root.size
    assert with_root.scores[10, 17] < 0.01
    assert with_root.yaw[10, 17] == pytest.approx(-2.0, abs=0.02)
    without = compute_dissimilarity(capture, MatchingOptions(k=3, resolution=32, velocity_seconds=0), scratch=tmp_path)
    assert without.scores[3, 10] < 0.01


def test_windows_stay_inside_clips_and_between_gaps(tmp_path):
    meshes = turned_walk(16, 2)
    clips = [("a", [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11]), ("b", range(5))]
    result = compute_dissimilarity(array_capture(meshes, clips=clips), QUICK, scratch=tmp_path)
    assert np.flatnonzero(np.isfinite(np.diagonal(result.scores))).tolist() == [2, 3, 8, 13]


def test_tiles_and_files_do_not_show(walk, walk_result, tmp_path, monkeypatch):
    monkeypatch.setattr(dissimilarity, "TILE", 4)
    monkeypatch.setattr(correlation, "CHUNK", 5)
    monkeypatch.setattr(fields, "BLOCK", 3)
    progress = []
    tiled = compute_dissimilarity(walk, QUICK, scratch=tmp_path, progress=lambda *report: progress.append(report))
    np.testing.assert_allclose(tiled.scores**2, walk_result.scores**2, atol=1e-7)
    assert progress == sorted(progress) and progress[-1] == (42, 42) and {total for _, total in progress} == {42}
    assert list(tmp_path.iterdir()) == []


def test_workers_do_not_change_a_bit(walk, walk_result, tmp_path):
    with ProcessPoolExecutor(2) as executor:
        shared = compute_dissimilarity(walk, QUICK, scratch=tmp_path, executor=executor)
    assert shared.scores.tobytes() == walk_result.scores.tobytes()
    assert shared.yaw.tobytes() == walk_result.yaw.tobytes()


@pytest.mark.parametrize("count", [1, 4])
def test_a_capture_shorter_than_a_window_has_no_scores(count, tmp_path):
    result = compute_dissimilarity(array_capture([figure(0.0)] * count), QUICK, scratch=tmp_path)
    assert result.scores.shape == (count, count) and np.isnan(result.scores).all()


def test_real_frames_turned_and_cut_otherwise(tmp_path):
    """Real frames against a copy of them turned between grid angles: yaw within a degree, next to no distance."""
    real = open_capture(real_capture("liam", "0:9"))
    meshes = [(mesh.vertices, mesh.faces) for mesh in map(real.read, range(9))]
    turn = np.radians(41.3)
    motion = PlanarRigid(turn, 0.5, -1.0)
    order = np.random.default_rng(0)
    turned = [(motion.apply(v), np.ascontiguousarray(order.permutation(f)[:, [1, 2, 0]])) for v, f in meshes]
    capture = array_capture(meshes + turned, clips=[("as it is", range(9)), ("turned", range(9))])
    result = compute_dissimilarity(capture, QUICK, scratch=tmp_path)
    pairs = np.arange(2, 7), np.arange(11, 16)
    assert np.abs(np.degrees(result.yaw[pairs] + turn)).max() < 0.2
    assert result.scores[pairs].max() < 1e-3
    neighbours = result.scores[np.arange(2, 6), np.arange(3, 7)]
    assert neighbours.max() < 3e-3  # a man who stands still: not the grid's 10 mm


def test_adaptive_windows_take_the_length_that_fits_best(tmp_path):
    """Each pair's score is the least over the lengths, by H's weights; long windows only where they share no frame."""
    meshes = turned_walk(24, 4)
    clips = [("a", range(15)), ("b", range(9))]
    capture = array_capture(meshes, clips=clips)
    options = MatchingOptions(resolution=16, k=2, windows="adaptive", largest_k=4)
    found = compute_dissimilarity(capture, options, scratch=tmp_path)
    alone = []
    for k in (2, 3, 4):
        only = MatchingOptions(resolution=16, k=k, windows="adaptive", largest_k=k)
        one = compute_dissimilarity(capture, only, scratch=tmp_path)
        assert set(np.unique(one.k)) == {0, k}
        alone.append(one)
    index = np.arange(24)
    same = (index[:, None] < 15) == (index < 15)
    scores = np.stack([one.scores for one in alone])
    for position, k in enumerate((3, 4), 1):
        scores[position][same & (np.abs(index[:, None] - index) < 2 * k + 1)] = np.nan
    scores[np.isnan(scores)] = np.inf
    least = scores.min(axis=0)
    np.testing.assert_allclose(np.where(np.isinf(least), np.nan, least), found.scores, atol=2e-6)
    upper = np.triu(np.isfinite(found.scores), 1)
    chosen = np.choose(scores.argmin(axis=0), (2, 3, 4))
    clear = np.sort(scores, axis=0)[1] > least + 1e-5
    np.testing.assert_array_equal(found.k[upper & clear], chosen[upper & clear])
    assert len(set(found.k[upper].tolist())) > 1
    np.testing.assert_array_equal(found.k, found.k.T)
