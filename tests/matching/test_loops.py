import numpy as np
from array_capture import array_capture

from unstructured_mg.matching.candidates import eligible_pairs
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.loops import departs, short_loops
from unstructured_mg.matching.options import MatchingOptions

K = 3


def walk_then_stand(capture):
    """Poses on a circle, once round in 12 frames up to frame 40, then standing still; distances between them."""
    n = len(capture)
    poses = np.exp(2j * np.pi * np.minimum(np.arange(n), 40) / 12)
    scores = np.abs(poses[:, None] - poses).astype(np.float32)
    centres = capture.window_centres(K)
    both = centres[:, None] & centres
    k = np.where(both, K, 0).astype(np.int16)
    return Dissimilarity(np.where(both, scores, np.nan).astype(np.float32), np.zeros((n, n), np.float32), k, 1.8, "m")


def test_a_cycle_is_a_loop_and_standing_still_is_none():
    capture = array_capture(clips=[("a", range(70))])
    found = short_loops(capture, walk_then_stand(capture), 0.1, 30)
    s, t = np.nonzero(found)
    walking = t <= 40
    assert set(s[walking & (t - s == 12)].tolist()) == set(range(K, 29))
    assert set((t - s)[walking].tolist()) == {12, 24}
    # The walk ends standing in a pose that it passed before; within the stand there is no loop.
    assert set(((40 - s) % 12)[~walking].tolist()) == {0} and s.max() < 40


def test_loops_span_neither_gaps_nor_clips_and_share_no_frame():
    capture = array_capture(clips=[("a", [*range(20), *range(24, 44)]), ("b", range(20))])
    found = walk_then_stand(capture)
    for s, t in zip(*np.nonzero(short_loops(capture, found, 0.1, 30)), strict=True):
        run = next(run for run in capture.runs() if s in run)
        assert t in run and t - s >= 2 * K + 1


def test_departing_is_to_be_far_from_both_ends():
    scores = np.array([[0, 5, 9, 1.0], [5, 0, 4, 9], [9, 4, 0, 1], [1, 9, 1, 0]], np.float32)
    assert departs(scores, 0, 3, 4.0) and not departs(scores, 0, 3, 5.0)
    scores[0, 3] = scores[3, 0] = 2.6
    assert not departs(scores, 0, 3, 4.0)


def test_candidates_may_be_loops_only_where_asked():
    capture = array_capture(clips=[("a", range(70))])
    found = walk_then_stand(capture)
    pairs = [
        eligible_pairs(capture, found, 0.1, MatchingOptions(k=K, minimum_gap_seconds=1.0, loops=loops))
        for loops in (True, False)
    ]
    np.testing.assert_array_equal(pairs[0] & ~pairs[1], short_loops(capture, found, 0.1, 30))
    assert (pairs[0] >= pairs[1]).all() and pairs[0][5, 17] and not pairs[1][5, 17]
