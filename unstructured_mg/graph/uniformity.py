"""Why a graph cannot be walked so that all captured frames are visited equally often."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from unstructured_mg.capture.capture import Capture
from unstructured_mg.graph.frame_graph import FrameGraph
from unstructured_mg.graph.frame_ranges import frame_ranges
from unstructured_mg.graph.link import Link


@dataclass(frozen=True)
class Obstacle:
    """``crowd`` frames have only the fewer ``narrow`` frames to go to (or to come from).

    So the narrow frames together are visited as often as the crowd together: uniform visits are impossible.

    Attributes
    ----------
    leads_to : True where every way on from ``crowd`` is to ``narrow``, False where every way into ``crowd`` is from it
    crowd, narrow : captured frames, ascending; there is one more in ``crowd``
    """

    leads_to: bool
    crowd: tuple[int, ...]
    narrow: tuple[int, ...]


def obstacle_sentence(obstacle: Obstacle, capture: Capture) -> str:
    """For people, with frame ids."""
    crowd, narrow = frame_ranges(obstacle.crowd, capture), frame_ranges(obstacle.narrow, capture)
    ways = "lead only to" if obstacle.leads_to else "are reached only from"
    many = "both" if len(obstacle.crowd) == 2 else f"these {len(obstacle.crowd)}"
    single = len(obstacle.narrow) == 1
    noun, they = ("frame", "it is") if single else ("frames", "those are")
    return f"Frames {crowd} {ways} {noun} {narrow}, so {they} visited as often as {many} together."


def find_obstacles(graph: FrameGraph, links: Sequence[Link], kept: np.ndarray) -> tuple[Obstacle, ...]:
    """The obstacles among the ``kept`` nodes, none where (almost) exactly uniform visits are possible.

    Uniform visits are a doubly stochastic matrix on the captured frames, where each link joins the frames it leaves and
    arrives at. By Birkhoff's theorem one exists exactly where each frame can be given a successor of its own: a perfect
    matching. Each frame that a maximum matching leaves over proves a violation of Hall's condition: the frames on
    alternating paths from it have one successor fewer than they are.
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
    for leads_to, ways in ((True, after), (False, before)):
        mate = maximum_bipartite_matching(ways, perm_type="row")  # of each column
        for left_over in np.setdiff1d(np.arange(len(frames)), mate):
            crowd, narrow = _reach(ways, mate, int(left_over))
            found.append(Obstacle(leads_to, _frames(frames, crowd), _frames(frames, narrow)))
    return tuple(found)


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
