"""Why a graph cannot be walked so that all captured frames are visited equally often."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching, maximum_flow

from unstructured_mg.capture.capture import Capture
from unstructured_mg.graph.frame_graph import FrameGraph
from unstructured_mg.graph.frame_ranges import frame_ranges
from unstructured_mg.graph.link import Link

# Wanted shares are told apart to this part of all visits.
PRECISION = 1_000_000


@dataclass(frozen=True)
class Obstacle:
    """``crowd`` frames have only the fewer ``narrow`` frames to go to (or to come from).

    So the narrow frames together are visited as often as the crowd together: uniform visits are impossible.

    Attributes
    ----------
    leads_to : True where every way on from ``crowd`` is to ``narrow``, False where every way into ``crowd`` is from it
    crowd, narrow : captured frames, ascending; where all frames are wanted alike there is one more in ``crowd``
    excess : how much more is wanted of the crowd than of the narrow frames, as a share of all visits
    """

    leads_to: bool
    crowd: tuple[int, ...]
    narrow: tuple[int, ...]
    excess: float


def obstacle_sentence(obstacle: Obstacle, capture: Capture) -> str:
    """For people, with frame ids."""
    crowd, narrow = frame_ranges(obstacle.crowd, capture), frame_ranges(obstacle.narrow, capture)
    ways = "lead only to" if obstacle.leads_to else "are reached only from"
    many = "both" if len(obstacle.crowd) == 2 else f"these {len(obstacle.crowd)}"
    single = len(obstacle.narrow) == 1
    if len(obstacle.crowd) != len(obstacle.narrow) + 1:
        noun, crowd_noun = ("frame" if len(f) == 1 else "frames" for f in (obstacle.narrow, obstacle.crowd))
        only = "lead only to" if obstacle.leads_to else "are reached only from"
        if len(obstacle.crowd) == 1:
            only = "leads only to" if obstacle.leads_to else "is reached only from"
        return (
            f"{crowd_noun.capitalize()} {crowd} {only} {noun} {narrow}, of which less is wanted, by "
            f"{100 * obstacle.excess:.1f} % of all visits."
        )
    noun, they = ("frame", "it is") if single else ("frames", "those are")
    return f"Frames {crowd} {ways} {noun} {narrow}, so {they} visited as often as {many} together."


def find_obstacles(
    graph: FrameGraph, links: Sequence[Link], kept: np.ndarray, weights: np.ndarray | None = None
) -> tuple[Obstacle, ...]:
    """The obstacles among the ``kept`` nodes, none where visits can be (almost) exactly as wanted: uniform, or in
    proportion to ``weights`` (captured,).

    Uniform visits are a doubly stochastic matrix on the captured frames, where each link joins the frames it leaves and
    arrives at. By Birkhoff's theorem one exists exactly where each frame can be given a successor of its own: a perfect
    matching. Each frame that a maximum matching leaves over proves a violation of Hall's condition: the frames on
    alternating paths from it have one successor fewer than they are.

    With weights a flow from each frame to its successors takes the matching's place, with as much out of each frame and
    into each as is wanted of it (in millionths of all): where the greatest flow leaves something over at a frame, what
    can be reached from it in the residual network is the crowd, and its successors are all full.
    """
    captured = graph.captured
    inside = kept[graph.source] & kept[graph.target]
    plain = inside & (graph.source < captured) & (graph.target < captured)
    used = [link for index, link in enumerate(links) if kept[graph.first_step[index]]]
    source = np.concatenate([graph.source[plain], np.array([link.leaves for link in used], np.int32)])
    target = np.concatenate([graph.target[plain], np.array([link.arrives for link in used], np.int32)])
    frames = np.flatnonzero(kept[:captured])
    source, target = np.searchsorted(frames, source), np.searchsorted(frames, target)
    shape = (len(frames), len(frames))
    after = csr_array((np.ones(len(source)), (source, target)), shape=shape)
    before = csr_array((np.ones(len(source)), (target, source)), shape=shape)
    found = []
    wanted = None
    if weights is not None and np.ptp(weights[frames]) > 0:
        wanted = np.rint(weights[frames] / weights[frames].sum() * PRECISION).astype(np.int64)
    for leads_to, ways in ((True, after), (False, before)):
        if wanted is not None:
            for crowd, narrow, excess in _overfull(ways, wanted):
                found.append(Obstacle(leads_to, _frames(frames, crowd), _frames(frames, narrow), excess))
            continue
        mate = maximum_bipartite_matching(ways, perm_type="row")  # of each column
        for left_over in np.setdiff1d(np.arange(len(frames)), mate):
            crowd, narrow = _reach(ways, mate, int(left_over))
            found.append(Obstacle(leads_to, _frames(frames, crowd), _frames(frames, narrow), 1 / len(frames)))
    return tuple(found)


def _overfull(ways: csr_array, wanted: np.ndarray) -> list[tuple[set[int], set[int], float]]:
    """(crowd, narrow, excess) positions where ``wanted`` (int, the same sum both ways) cannot flow along ``ways``."""
    size = len(wanted)
    rows, columns = ways.nonzero()
    everything = int(wanted.sum())
    # The frames as they are left, the frames as they are entered, a source and a sink.
    network = csr_array(
        (
            np.concatenate([wanted, np.full(len(rows), everything), wanted]).astype(np.int32),
            (
                np.concatenate([np.full(size, 2 * size), rows, size + np.arange(size)]),
                np.concatenate([np.arange(size), size + columns, np.full(size, 2 * size + 1)]),
            ),
        ),
        shape=(2 * size + 2, 2 * size + 2),
    )
    flow = csr_array(maximum_flow(network, 2 * size, 2 * size + 1).flow)
    sent = flow[[2 * size], :].toarray()[0, :size]
    between = csr_array(flow[:size, size : 2 * size])
    between.data[between.data < 0] = 0
    between.eliminate_zeros()
    senders = csr_array(between.T)
    found: list[tuple[set[int], set[int], float]] = []
    for start in np.flatnonzero(sent < wanted):
        crowd, narrow, waiting = {int(start)}, set[int](), [int(start)]
        while waiting:
            row = waiting.pop()
            for column in ways.indices[ways.indptr[row] : ways.indptr[row + 1]].tolist():
                if column not in narrow:
                    narrow.add(column)
                    for sender in senders.indices[senders.indptr[column] : senders.indptr[column + 1]].tolist():
                        if sender not in crowd:
                            crowd.add(sender)
                            waiting.append(sender)
        excess = float(wanted[sorted(crowd)].sum() - wanted[sorted(narrow)].sum()) / everything
        if all(crowd != other for other, _, _ in found):
            found.append((crowd, narrow, excess))
    return found


def _reach(ways: csr_array, mate: np.ndarray, start: int) -> tuple[set[int], set[int]]:
    crowd, narrow, waiting = {start}, set(), [start]
    while waiting:
        row = waiting.pop()
        for column in ways.indices[ways.indptr[row] : ways.indptr[row + 1]].tolist():
            if column not in narrow:
                narrow.add(column)
                crowd.add(int(mate[column]))
                waiting.append(int(mate[column]))
    return crowd, narrow


def _frames(frames: np.ndarray, positions: set[int]) -> tuple[int, ...]:
    return tuple(int(frames[position]) for position in sorted(positions))
