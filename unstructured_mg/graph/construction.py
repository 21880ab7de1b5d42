"""Which pairs of windows a motion graph is made of: one function for each way of choosing them."""

from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.graph.essential import QUANTUM, complete_costs, essential_graph
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.warp import best_warp
from unstructured_mg.matching.candidates import Candidate, eligible_pairs, is_near, spread_pairs
from unstructured_mg.matching.match import Matching
from unstructured_mg.matching.options import MatchingOptions

Choose = Callable[[Capture, Matching, MatchingOptions, GraphOptions, Executor | None], tuple[Candidate, ...]]
Near = Callable[[Candidate, Iterable[Candidate], Capture, MatchingOptions], bool]


@dataclass(frozen=True)
class Construction:
    """A way of choosing pairs.

    Attributes
    ----------
    choose : candidates in the order in which they are to be tried
    is_near : whether a candidate is not needed any more beside those that were accepted
    """

    choose: Choose
    is_near: Near


def local_windows(
    capture: Capture, matching: Matching, options: MatchingOptions, graph: GraphOptions, executor: Executor | None
) -> tuple[Candidate, ...]:
    """P section 4: the best pairs of windows that are no nearer to each other than P A.1 says."""
    return matching.candidates


def surface(
    capture: Capture, matching: Matching, options: MatchingOptions, graph: GraphOptions, executor: Executor | None
) -> tuple[Candidate, ...]:
    """H section 3.3: of every two clips, and of every clip with itself, the best pair of windows (H eq. 5).

    The next best ones, in places of their own, stand behind it for when it is refused. None is worse than the
    threshold, where H joins whatever the user says.
    """
    names = {name: number for number, name in enumerate(capture.clips)}
    clip = np.array([names[frame.clip] for frame in capture.frames])
    scores = matching.dissimilarity.scores
    scores = np.where(eligible_pairs(capture, matching.dissimilarity, matching.threshold, options), scores, np.inf)
    scores[scores > matching.threshold] = np.inf
    found: list[tuple[int, int]] = []
    for first in range(len(names)):
        for second in range(first, len(names)):
            both = (clip[:, None] == first) & (clip == second)
            pairs = spread_pairs(np.where(both | both.T, scores, np.inf), capture, options)
            pairs.sort(key=lambda pair: (scores[pair], pair))
            found += pairs[: 1 + options.alternatives]
    d = matching.dissimilarity
    candidates = [Candidate(s, t, float(scores[s, t]), float(d.yaw[s, t]), int(d.k[s, t])) for s, t in found]
    return tuple(sorted(candidates, key=lambda c: (c.score, c.source, c.target)))


def same_clips(candidate: Candidate, accepted: Iterable[Candidate], capture: Capture, options: MatchingOptions) -> bool:
    """Whether the same two clips have been joined."""
    clips = [capture.frames[frame].clip for frame in (candidate.source, candidate.target)]
    return any(clips == [capture.frames[frame].clip for frame in (o.source, o.target)] for o in accepted)


def essential(
    capture: Capture, matching: Matching, options: MatchingOptions, graph: GraphOptions, executor: Executor | None
) -> tuple[Candidate, ...]:
    """B section 3: the transitions of the essential graph, the one that most pairs of frames need first.

    The pose distance is the dissimilarity of the windows about two frames, whatever it is made of; pairs of frames that
    matching calls too close in time are never blended. A transition is a candidate where its mean pose distance is no
    more than the threshold, and of those that leave and arrive near each other the first ones, as ``rank_candidates``.
    """
    scores, runs = matching.dissimilarity.scores, capture.runs()
    eligible = eligible_pairs(capture, matching.dissimilarity, matching.threshold, options)
    distances = np.where(eligible | eligible.T, scores, np.nan)
    alpha = graph.frame_share * matching.threshold
    shortest, longest = (max(5, round(s * capture.fps)) for s in (graph.shortest_seconds, graph.longest_seconds))
    costs = complete_costs(distances, runs, alpha, shortest, longest, executor=executor)
    found = essential_graph(costs, runs, alpha)
    rank = np.full(distances.shape, np.inf)
    rank[found.leaves, found.arrives] = -found.used.astype(np.float64)
    # No warp has more pairs than this: what is dearer is above the threshold.
    rank[costs * QUANTUM > 2 * longest * (matching.threshold + alpha)] = np.inf
    candidates: dict[tuple[int, int], Candidate] = {}
    pairs = sorted(spread_pairs(rank, capture, options), key=lambda pair: (rank[pair], pair))
    for leaves, arrives in pairs[: graph.most_candidates]:
        warp = best_warp(distances, runs, leaves, arrives, alpha, shortest, longest, odd=True)
        assert warp is not None
        score = warp.cost / len(warp.source) - alpha
        if score <= matching.threshold:
            candidate = _warped(warp.source, warp.target, score, matching.dissimilarity.yaw)
            own, other = candidate.windows
            if own.stop <= other.start:  # no frame is in both
                candidates.setdefault((candidate.source, candidate.target), candidate)
    return tuple(candidates.values())


def _warped(leaving: np.ndarray, meeting: np.ndarray, score: float, yaw: np.ndarray) -> Candidate:
    """The earlier window is the source: both directions are made in any case."""
    ways = tuple(int(frame) for frame in leaving), tuple(int(frame) for frame in meeting)
    k = len(leaving) // 2
    source, target = sorted(ways, key=lambda way: way[k])
    turn = float(yaw[source[k], target[k]])
    return Candidate(source[k], target[k], float(score), turn, k, (source, target))


CONSTRUCTIONS = {
    "local_windows": Construction(local_windows, is_near),
    "surface": Construction(surface, same_clips),
    "essential": Construction(essential, is_near),
}
