import numpy as np
import pytest
from array_capture import array_capture
from scipy.ndimage import gaussian_filter

from unstructured_mg.matching.candidates import Candidate, eligible_pairs, is_near, nearest_pairs, rank_candidates
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.options import MatchingOptions

CLIPS = [("a", range(70)), ("b", [*range(10), *range(14, 50)])]
COUNT = 116
CAPTURE = array_capture(clips=CLIPS)
OPTIONS = MatchingOptions(k=2, minimum_gap_seconds=1.0, separation_seconds=10 / 30, alternatives=0, loops=False)


def scores(seed):
    noise = gaussian_filter(np.random.default_rng(seed).random((COUNT, COUNT)), 2)
    values = (noise + noise.T).astype(np.float32)
    centres = CAPTURE.window_centres(2)
    values[~(centres[:, None] & centres)] = np.nan
    k = np.where(np.isnan(values), 0, 2).astype(np.int16)
    return Dissimilarity(values, np.zeros_like(values), k, 1.8, "m")


def far_apart(s, t, options):
    a, b = CAPTURE.frames[s], CAPTURE.frames[t]
    return a.clip != b.clip or abs(a.number - b.number) >= max(30 * options.minimum_gap_seconds, 5)


def chosen_as_the_paper_does(dissimilarity, threshold, count=None):
    pairs = sorted(
        (dissimilarity.scores[s, t], s, t)
        for s in range(COUNT)
        for t in range(s + 1, COUNT)
        if np.isfinite(dissimilarity.scores[s, t])
        and far_apart(s, t, OPTIONS)
        and dissimilarity.scores[s, t] <= threshold
    )
    chosen = []
    for _, s, t in pairs:
        if not any(abs(s - a) < 10 and abs(t - b) < 10 for a, b in chosen):
            chosen.append((s, t))
    return chosen[:count]


@pytest.mark.parametrize("seed", range(3))
def test_without_refusals_the_list_is_the_papers_choice(seed):
    found = scores(seed)
    threshold = float(np.nanquantile(found.scores, 0.2))
    candidates = rank_candidates(CAPTURE, found, threshold, OPTIONS)
    expected = chosen_as_the_paper_does(found, threshold)
    assert len(expected) > 10
    assert [(c.source, c.target) for c in candidates] == expected
    assert [c.score for c in candidates] == [found.scores[s, t] for s, t in expected]
    near = nearest_pairs(CAPTURE, found, threshold, OPTIONS)
    assert [(c.source, c.target) for c in near] == chosen_as_the_paper_does(found, np.inf, OPTIONS.nearest)


def test_eligible_pairs_have_scores_and_share_no_frame():
    for gap in (0.0, 1.0):
        options = MatchingOptions(k=2, minimum_gap_seconds=gap, loops=False)
        eligible = eligible_pairs(CAPTURE, scores(0), 1.0, options)
        for s in range(COUNT):
            for t in range(COUNT):
                expected = s < t and np.isfinite(scores_0[s, t]) and far_apart(s, t, options)
                assert eligible[s, t] == expected


scores_0 = scores(0).scores


def test_alternatives_are_near_but_apart_and_capped():
    found = scores(1)
    threshold = float(np.nanquantile(found.scores, 0.3))
    first = {(c.source, c.target) for c in rank_candidates(CAPTURE, found, threshold, OPTIONS)}
    options = MatchingOptions(k=2, minimum_gap_seconds=1.0, separation_seconds=10 / 30, alternatives=2, loops=False)
    candidates = rank_candidates(CAPTURE, found, threshold, options)
    pairs = [(c.source, c.target) for c in candidates]
    extra = [pair for pair in pairs if pair not in first]
    assert first < set(pairs) and len(set(pairs)) == len(pairs) and len(extra) <= 2 * len(first)
    assert len(extra) > len(first) / 2
    eligible = eligible_pairs(CAPTURE, found, 1.0, options)
    for s, t in extra:
        assert eligible[s, t] and found.scores[s, t] <= threshold
        assert any(abs(s - a) < 10 and abs(t - b) < 10 for a, b in first)
        assert all(abs(s - a) >= 2 or abs(t - b) >= 2 for a, b in pairs if (a, b) != (s, t))
    assert [c.score for c in candidates] == sorted(c.score for c in candidates)


def test_near_means_both_ends_in_the_same_clip_and_close():
    def near(s, t, a, b):
        return is_near(Candidate(s, t, 0, 0, 2), [Candidate(a, b, 0, 0, 2)], CAPTURE, OPTIONS)

    assert near(10, 50, 19, 41) and near(10, 50, 1, 59)
    assert not near(10, 50, 20, 50) and not near(10, 50, 10, 40)
    assert not near(10, 66, 10, 72)  # 6 indices apart, but in the next clip
    assert near(10, 79, 10, 81) and not near(
        10, 79, 10, 85
    )  # frames 9 and 15; a gap of 4 frames lies between: 9 and 19
    assert not is_near(Candidate(10, 50, 0, 0, 2), [], CAPTURE, OPTIONS)


def test_frame_rate_scales_the_rules():
    twice = array_capture(fps=60.0, clips=CLIPS)
    eligible = eligible_pairs(twice, scores(0), 1.0, OPTIONS)
    assert not eligible[5, 64] and eligible[5, 65]
    assert is_near(Candidate(10, 50, 0, 0, 2), [Candidate(29, 69, 0, 0, 2)], twice, OPTIONS)


def test_nothing_below_the_threshold_gives_an_empty_list():
    assert rank_candidates(CAPTURE, scores(0), 0.0, OPTIONS) == ()


def test_every_pair_has_its_own_window():
    """Where windows are long, frames must be farther apart for the windows not to share one; candidates know theirs."""
    found = scores(2)
    k = np.where(np.arange(COUNT)[:, None] + np.arange(COUNT) > 60, 20, 2).astype(np.int16)
    k[np.isnan(found.scores)] = 0
    found = Dissimilarity(found.scores, found.yaw, k, found.size, "m")
    options = MatchingOptions(k=2, minimum_gap_seconds=0.0)
    eligible = eligible_pairs(CAPTURE, found, 1.0, options)
    assert eligible[20, 25] and not eligible[20, 24] and not eligible[20, 60] and eligible[20, 61]
    candidates = rank_candidates(CAPTURE, found, np.inf, options)
    assert {c.k for c in candidates} == {2, 20}
    assert all(c.k == k[c.source, c.target] for c in candidates)
