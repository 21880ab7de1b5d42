"""Transitions of variable length by dynamic time warping (B section 3.2)."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from unstructured_mg import _native
from unstructured_mg.matching.tasks import run

# Of the compiled kernel: starts that are worked on side by side, and rows that make a task.
LANES, BLOCK = 16, 64
# Steps in one direction that may follow each other (B section 3.2).
MOST_IN_A_ROW = 3


@dataclass(frozen=True)
class Warp:
    """Which frames are blended at each step of a transition.

    Attributes
    ----------
    source, target : (L,) int32 frame indices, each never falling and growing by one at most; no step keeps both
    cost : the pose distances of the L pairs, with what each pair costs besides, added up
    """

    source: np.ndarray
    target: np.ndarray
    cost: float


def warp_costs(
    distances: np.ndarray,
    runs: Sequence[range],
    per_pair: float,
    shortest: int,
    longest: int,
    *,
    odd: bool,
    executor: Executor | None = None,
) -> np.ndarray:
    """(n, n) float32: at i, j what the best transition that leaves frame i and arrives at frame j costs, inf without.

    B eq. 4 to 6 with both terms minimised at once: E(i, j) = min over l_i, l_j and warps of the sum over the L pairs of
    ``d(a, b) + per_pair``, where the first pair is (i, j - l_j + 1), the last (i + l_i - 1, j), and each pair advances
    one or both of its frames, one alone at most three times in a row. B takes the warp of least sum of d and adds
    alpha L for it; E is never above that.

    Parameters
    ----------
    distances : (n, n) float32 pose distances d; what is not finite takes no part
    runs : the capture's; transitions do not cross their ends
    per_pair : B's alpha
    shortest, longest : frames of l_i and l_j
    odd : only warps with an odd number of pairs: those have a middle, as all transitions here
    """
    n = len(distances)
    columns = _spread_columns(n, runs)
    wide = int(columns[-1]) + 1 + longest + LANES if n else 0
    costs = np.full((n, wide), np.inf, np.float32)
    costs[:, columns] = np.where(np.isfinite(distances), distances + np.float32(per_pair), np.inf)
    stops = np.zeros(n, np.int32)
    for each in runs:
        stops[each.start : each.stop] = each.stop
    tasks = []
    for first in range(0, n, BLOCK):
        last = min(first + BLOCK, n)
        reach = min(last + longest, n)
        tasks.append((costs[first:reach], stops[first:reach] - first, last - first, shortest, longest, odd))
    best = [part[:, columns] for part in run(_block, tasks, executor)]
    return np.concatenate([np.zeros((0, n), np.float32), *best])


def _block(costs: np.ndarray, stops: np.ndarray, count: int, shortest: int, longest: int, odd: bool) -> np.ndarray:
    best = np.empty((count, costs.shape[1]), np.float32)
    height, wide = costs.shape
    stops = np.ascontiguousarray(stops, np.int32)
    _native.warp_costs(np.ascontiguousarray(costs), stops, best, height, wide, 0, count, shortest, longest, odd)
    return best


def _spread_columns(n: int, runs: Sequence[range]) -> np.ndarray:
    """Each frame's column, with one column between runs that no way can cross."""
    columns = np.arange(n)
    for number, each in enumerate(runs):
        columns[each.start : each.stop] += number
    return columns


def best_warp(
    distances: np.ndarray,
    runs: Sequence[range],
    leaves: int,
    arrives: int,
    per_pair: float,
    shortest: int,
    longest: int,
    *,
    odd: bool,
) -> Warp | None:
    """A warp that costs what ``warp_costs`` says; of equal ones the first in the order of the choices below."""
    source_run, target_run = (next(each for each in runs if frame in each) for frame in (leaves, arrives))
    rows = range(leaves, min(leaves + longest, source_run.stop))
    columns = range(max(arrives - longest + 1, target_run.start), arrives + 1)
    part = distances[rows.start : rows.stop, columns.start : columns.stop]
    costs = np.where(np.isfinite(part), part + np.float32(per_pair), np.float32(np.inf)).astype(np.float32)
    # A state is how many pairs so far are odd, and how many of the last steps went across (1 to 3) or down (-1 to -3).
    states = [(parity, steps) for parity in (1, 0) for steps in range(-MOST_IN_A_ROW, MOST_IN_A_ROW + 1)]
    number = {state: index for index, state in enumerate(states)}
    value = np.full((len(states), *costs.shape), np.inf, np.float32)
    came = np.full((len(states), *costs.shape), -1, np.int32)
    starts = len(columns) - shortest + 1
    if starts > 0:
        value[number[1, 0], 0, :starts] = costs[0, :starts]
    for row in range(len(rows)):
        for column in range(len(columns)):
            if not np.isfinite(costs[row, column]):
                continue
            for state, (parity, steps) in enumerate(states):
                down, across = steps <= 0, steps >= 0
                before = (row - down, column - across)
                if before[0] < 0 or before[1] < 0:
                    continue
                allowed = _before(1 - parity, steps)
                found = value[[number[other] for other in allowed], before[0], before[1]]
                least = int(np.argmin(found))
                paid = found[least] + costs[row, column]
                if paid < value[state, row, column]:
                    value[state, row, column] = paid
                    came[state, row, column] = number[allowed[least]]
    ends = value[: MOST_IN_A_ROW * 2 + 1] if odd else value
    last = ends[:, shortest - 1 :, -1]
    if last.size == 0 or not np.isfinite(last).any():
        return None
    state, row = (int(i) for i in np.unravel_index(np.argmin(last), last.shape))
    row, column = row + shortest - 1, len(columns) - 1
    cost = float(value[state, row, column])
    path = []
    while state >= 0:
        path.append((rows[row], columns[column]))
        steps, state = states[state][1], int(came[state, row, column])
        row, column = row - (steps <= 0), column - (steps >= 0)
    pairs = np.array(path[::-1], np.int32)
    return Warp(pairs[:, 0], pairs[:, 1], cost)


def _before(parity: int, steps: int) -> list[tuple[int, int]]:
    """The states from which a step can have led to one with ``steps`` in its direction so far."""
    every = range(-MOST_IN_A_ROW, MOST_IN_A_ROW + 1)
    if steps == 0:
        return [(parity, other) for other in every]
    if abs(steps) > 1:
        return [(parity, steps - (1 if steps > 0 else -1))]
    return [(parity, other) for other in every if other * steps <= 0]
