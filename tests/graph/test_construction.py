import dataclasses

import numpy as np
import pytest
from array_capture import array_capture

from unstructured_mg.graph.construction import CONSTRUCTIONS
from unstructured_mg.graph.options import CONSTRUCTION_NAMES, GraphOptions
from unstructured_mg.matching.candidates import Candidate, eligible_pairs, is_near, nearest_pairs, rank_candidates
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.match import Matching
from unstructured_mg.matching.options import MatchingOptions

CAPTURE = array_capture(clips=[("a", range(60)), ("b", range(50)), ("c", range(40))])
COUNT = len(CAPTURE)
OPTIONS = MatchingOptions(k=2, minimum_gap_seconds=0.5, separation_seconds=0.3, alternatives=1)
GRAPH = GraphOptions(shortest_seconds=0.2, longest_seconds=0.5)


def matching(seed=0, threshold=0.2):
    """Poses that wander through the plane; windows of the poses about them."""
    walk = np.cumsum(np.random.default_rng(seed).normal(scale=0.08, size=(COUNT, 2)), axis=0)
    scores = np.linalg.norm(walk[:, None] - walk, axis=2).astype(np.float32)
    centres = CAPTURE.window_centres(2)
    scores[~(centres[:, None] & centres)] = np.nan
    yaw = np.where(np.isnan(scores), np.nan, np.subtract.outer(np.arange(COUNT), np.arange(COUNT)) / 100)
    k = np.where(np.isnan(scores), 0, 2).astype(np.int16)
    found = Dissimilarity(scores, yaw.astype(np.float32), k, 1.8, "m")
    ranked = rank_candidates(CAPTURE, found, threshold, OPTIONS)
    return Matching(found, ranked, nearest_pairs(CAPTURE, found, threshold, OPTIONS), (), threshold)


def chosen(name, seed=0, graph=GRAPH, threshold=0.2):
    return CONSTRUCTIONS[name].choose(CAPTURE, matching(seed, threshold), OPTIONS, graph, None)


def test_the_options_know_every_construction():
    assert set(CONSTRUCTION_NAMES) == set(CONSTRUCTIONS)
    with pytest.raises(ValueError, match="construction"):
        GraphOptions(construction="random")


def test_local_windows_are_those_of_matching():
    assert chosen("local_windows") == matching().candidates and CONSTRUCTIONS["local_windows"].is_near is is_near


@pytest.mark.parametrize("seed", range(3))
def test_a_surface_graph_joins_every_two_clips_at_their_best(seed):
    found, given = chosen("surface", seed), matching(seed)
    eligible = eligible_pairs(CAPTURE, given.dissimilarity, given.threshold, OPTIONS)
    clip = np.array([frame.clip for frame in CAPTURE.frames])
    near = CONSTRUCTIONS["surface"].is_near
    accepted: list[Candidate] = []
    for candidate in found:
        if not near(candidate, accepted, CAPTURE, OPTIONS):
            accepted.append(candidate)
    joined = {}
    for a in "abc":
        for b in "abc":
            there = eligible & (clip[:, None] == a) & (clip == b)
            least = given.dissimilarity.scores[there].min() if there.any() else np.inf
            if least <= given.threshold:
                joined[a, b] = least
    assert {(clip[c.source], clip[c.target]): np.float32(c.score) for c in accepted} == joined
    assert len(found) <= 2 * len(joined)
    assert all(c.k == 2 and c.warp is None for c in found)


@pytest.mark.parametrize("seed", range(3))
def test_essential_candidates_are_warps_within_the_threshold(seed):
    found, given = chosen("essential", seed), matching(seed)
    scores, runs = given.dissimilarity.scores, CAPTURE.runs()
    assert found
    for candidate in found:
        source, target = candidate.warp
        k = candidate.k
        assert len(source) == len(target) == 2 * k + 1
        assert (source[k], target[k]) == (candidate.source, candidate.target)
        assert candidate.source < candidate.target
        assert candidate.yaw == pytest.approx(given.dissimilarity.yaw[candidate.source, candidate.target])
        paid = [float(scores[pair]) for pair in zip(source, target, strict=True)]
        assert candidate.score == pytest.approx(np.mean(paid), rel=1e-4) and candidate.score <= given.threshold
        for way in (source, target):
            assert set(np.diff(way)) <= {0, 1} and any(way[0] in run and way[-1] in run for run in runs)
            assert round(0.2 * 30) <= way[-1] - way[0] + 1 <= round(0.5 * 30)
        window, other = candidate.windows
        assert not set(window) & set(other)
    assert len({(c.source, c.target) for c in found}) == len(found)


def test_fewer_may_be_looked_at_and_none_where_nothing_is_alike():
    few = chosen("essential", graph=dataclasses.replace(GRAPH, most_candidates=2))
    assert few == chosen("essential")[: len(few)] and len(few) <= 2
    assert chosen("essential", threshold=1e-6) == () and chosen("surface", threshold=1e-6) == ()


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"frame_share": 0.0}, "frame_share"),
        ({"shortest_seconds": 3.0}, "longest_seconds"),
        ({"most_candidates": 0}, "most_candidates"),
    ],
)
def test_options_out_of_range_name_themselves(given, name):
    with pytest.raises(ValueError, match=f"^{name}"):
        GraphOptions(**given)
