"""The essential graph: no more transitions than the cheapest ways between all pairs of frames take (B section 3.3)."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra, floyd_warshall

from unstructured_mg.graph.warp import warp_costs

# Costs are whole multiples of this, so that sums of them are exact and "as cheap" is no matter of rounding.
QUANTUM = 2.0**-20


@dataclass(frozen=True)
class EssentialGraph:
    """Which transitions are worth having.

    Attributes
    ----------
    leaves, arrives : (m,) int32 captured frames that the transitions join, by leaves, then arrives
    cost : (m,) float64 B's E
    used : (m,) int64 for how many ordered pairs of frames a cheapest way takes the transition
    distances : (n, n) float64 cost of the cheapest way from each frame to each other, in the essential graph and in the
        complete one alike; inf where there is none
    """

    leaves: np.ndarray
    arrives: np.ndarray
    cost: np.ndarray
    used: np.ndarray
    distances: np.ndarray


def complete_costs(
    distances: np.ndarray,
    runs: Sequence[range],
    alpha: float,
    shortest: int,
    longest: int,
    *,
    odd: bool = True,
    executor: Executor | None = None,
) -> np.ndarray:
    """(n, n) float64, in whole ``QUANTUM``: B's complete digraph, E of eq. 5 and 6.

    Between frames of one run, forward, playing the capture costs ``alpha`` a frame; everything else costs what its best
    transition does (``warp_costs``). The diagonal is 0.
    """
    costs = np.rint(warp_costs(distances, runs, alpha, shortest, longest, odd=odd, executor=executor) / QUANTUM)
    costs = costs.astype(np.float64)
    for each in runs:
        ahead = np.subtract.outer(np.arange(len(each)), np.arange(len(each))).T
        played = np.where(ahead > 0, ahead * np.rint(alpha / QUANTUM), np.inf)
        inside = slice(each.start, each.stop)
        costs[inside, inside] = np.minimum(costs[inside, inside], played)
    np.fill_diagonal(costs, 0)
    return np.asarray(costs)


def essential_graph(costs: np.ndarray, runs: Sequence[range], alpha: float) -> EssentialGraph:
    """The fewest edges of ``complete_costs`` that keep every cheapest way's cost (B eq. 7).

    B keeps the union of the shortest path trees of all frames. An edge i -> j is in some tree exactly where it is
    itself a cheapest way; where there is another way as cheap over other frames, a tree can do without it, and as all
    costs are positive and whole, so can all trees at once: what is left is the one smallest such graph. The way on to
    the next captured frame is always there.
    """
    n = len(costs)
    with np.errstate(invalid="ignore"):
        cheapest = floyd_warshall(np.where(np.isfinite(costs), costs, np.inf)) if n else costs.copy()
    captured = np.zeros((n, n), bool)
    for each in runs:
        captured[np.arange(each.start, each.stop - 1), np.arange(each.start + 1, each.stop)] = True
    step = np.rint(alpha / QUANTUM)
    for each in runs:
        # Farther along the capture is never an edge of its own: the captured frames between lead there as cheaply.
        inside = slice(each.start, each.stop)
        ahead = np.subtract.outer(np.arange(len(each)), np.arange(len(each))).T
        block = costs[inside, inside]
        captured[inside, inside] |= (ahead > 0) & (block == ahead * step)
    needed = np.isfinite(costs) & (costs == cheapest) & ~captured
    np.fill_diagonal(needed, False)
    edges: list[tuple[int, int]] = []
    for row in np.flatnonzero(needed.any(axis=1)):
        targets = np.flatnonzero(needed[row])
        over = cheapest[row][:, None] + cheapest[:, targets]
        over[row] = np.inf
        over[targets, np.arange(len(targets))] = np.inf
        edges += [(int(row), int(target)) for target in targets[over.min(axis=0) > costs[row, targets]]]
    leaves, arrives = np.array(edges, np.int32).reshape(-1, 2).T
    used = _uses(n, runs, step, leaves, arrives, costs[leaves, arrives])
    return EssentialGraph(leaves, arrives, costs[leaves, arrives] * QUANTUM, used, cheapest * QUANTUM)


def way_costs(
    n: int, runs: Sequence[range], step: float, leaves: np.ndarray, arrives: np.ndarray, cost: np.ndarray
) -> csr_array:
    """(n, n) costs of the steps along the capture, ``step`` each, and of transitions."""
    before = np.concatenate([np.zeros(0, int), *(np.arange(each.start, each.stop - 1) for each in runs)])
    values = np.concatenate([np.full(len(before), step), cost])
    return csr_array((values, (np.r_[before, leaves], np.r_[before + 1, arrives])), shape=(n, n))


def _uses(
    n: int, runs: Sequence[range], step: float, leaves: np.ndarray, arrives: np.ndarray, cost: np.ndarray
) -> np.ndarray:
    """For each transition the frames that lie behind it in the shortest path trees, over all trees."""
    matrix = way_costs(n, runs, step, leaves, arrives, cost)
    used = np.zeros(len(leaves), np.int64)
    for root in range(n):
        distance, before = dijkstra(matrix, indices=root, return_predecessors=True)
        # Frames behind each frame in this tree, itself included: from the farthest frame inwards.
        behind = np.isfinite(distance).astype(np.int64).tolist()
        above = before.tolist()
        for node in np.argsort(-distance, kind="stable").tolist():
            if above[node] >= 0:
                behind[above[node]] += behind[node]
        used += np.where(before[arrives] == leaves, np.array(behind)[arrives], 0)
    return used
