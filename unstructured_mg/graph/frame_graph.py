"""The uncontracted graph: one node a frame, captured or synthesized (P section 3)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from unstructured_mg.graph.link import Link


@dataclass(frozen=True)
class FrameGraph:
    """Captured frame i is node i; behind them lie the steps of each link in turn.

    Attributes
    ----------
    captured : number of captured frames
    first_step : (links + 1,) int32; node of each link's step -k+1, and at the end the number of nodes
    source, target : (edges,) int32 nodes
    """

    captured: int
    first_step: np.ndarray
    source: np.ndarray
    target: np.ndarray

    @property
    def nodes(self) -> int:
        return int(self.first_step[-1])


def build_frame_graph(captured: int, runs: Sequence[range], links: Sequence[Link]) -> FrameGraph:
    """Captured edges i -> i+1 inside each run, and a chain of steps for each link.

    Raises
    ------
    ValueError
        Where a link's windows do not fit into runs, or two links join the same source and target.
    """
    run_of = np.full(captured, -1)
    for number, run in enumerate(runs):
        run_of[run.start : run.stop] = number
    seen: set[tuple[int, int]] = set()
    for position, link in enumerate(links):
        _check_link(position, link, run_of, seen)
    first_step = captured + np.cumsum([0, *(len(link.steps) for link in links)])
    sources: list[np.ndarray] = []
    targets: list[np.ndarray] = []
    for run in runs:
        sources.append(np.arange(run.start, run.stop - 1))
        targets.append(np.arange(run.start + 1, run.stop))
    for link, first, stop in zip(links, first_step[:-1], first_step[1:], strict=True):
        steps = np.arange(first, stop)
        sources += [np.array([link.leaves]), steps]
        targets += [steps, np.array([link.arrives])]
    empty = np.zeros(0, np.int32)
    return FrameGraph(
        captured,
        first_step.astype(np.int32),
        np.concatenate([empty, *sources]).astype(np.int32),
        np.concatenate([empty, *targets]).astype(np.int32),
    )


def largest_loop(graph: FrameGraph) -> np.ndarray | None:
    """``(nodes,) bool``: the strongly connected component with the most captured frames, or None without any cycle.

    Of equally large ones the one with the lowest captured frame wins.
    """
    shape = (graph.nodes, graph.nodes)
    adjacency = coo_array((np.ones(len(graph.source)), (graph.source, graph.target)), shape=shape)
    count, label = connected_components(adjacency, directed=True, connection="strong")
    # Every cycle passes through a link's steps (captured edges only lead forward), so a component of one node has none.
    sizes = np.bincount(label[: graph.captured], minlength=count)
    sizes[np.bincount(label, minlength=count) < 2] = 0
    if count == 0 or sizes.max() == 0:
        return None
    # The first captured frame whose component is of the largest size breaks ties.
    best = int(label[np.argmax(sizes[label[: graph.captured]])])
    return np.asarray(label == best)


def _check_link(position: int, link: Link, run_of: np.ndarray, seen: set[tuple[int, int]]) -> None:
    if link.k < 1:
        raise ValueError(f"links[{position}].k: expected 1 or more, got {link.k}")
    source, target = (range(frame - link.k, frame + link.k + 1) for frame in (link.source, link.target))
    if link.ends is not None:  # of warped windows only these halves are played
        source, target = range(link.leaves, link.source + 1), range(link.target, link.arrives + 1)
    for name, frame, window in (("source", link.source, source), ("target", link.target, target)):
        first, last = window.start, window.stop - 1
        inside = 0 <= first <= last < len(run_of) and run_of[first] >= 0
        if not inside or np.any(run_of[first : last + 1] != run_of[first]):
            raise ValueError(f"links[{position}].{name}: expected frames {first} to {last} in one run, got {frame}")
    if (link.source, link.target) in seen:
        raise ValueError(f"links[{position}]: expected one link from {link.source} to {link.target}, got another")
    seen.add((link.source, link.target))
