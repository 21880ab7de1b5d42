"""Paths of a wanted distance and duration as one integer programme (H section 4)."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array, csr_array, vstack
from scipy.sparse.csgraph import connected_components

from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.routes import Routes

# What an error of one metre and of one frame counts beside one unit of a transition's cost (H section 4.1).
METRE_WEIGHT = 1 / 0.3
FRAME_WEIGHT = 1 / 10
# Where no duration is asked for, the shorter of equally good ones: a second is worth a centimetre or so.
HASTE = 1e-3


@dataclass(frozen=True)
class DistanceTime:
    """A solved query.

    Attributes
    ----------
    arcs : the path's arcs in order
    frames : frames after the start
    distance : metres
    objective : what was minimised; no path has less
    """

    arcs: tuple[int, ...]
    frames: int
    distance: float
    objective: float


def solve_distance_time(
    routes: Routes,
    distance: float | None,
    frames: int | None,
    *,
    exact_frames: bool = False,
    closed: bool = False,
    metre_weight: float = METRE_WEIGHT,
    frame_weight: float = FRAME_WEIGHT,
) -> DistanceTime | None:
    """The path from start to goal that minimises ``cost + metre_weight |d - distance| + frame_weight |t - frames|``.

    H eq. 6 to 14. The unknowns are how often each arc is played, n_a = 0, 1, 2, ...: at every node as many arcs end as
    begin, but for one more that begins at the start and ends at the goal. With the arcs' costs s, metres d, frames t:

        minimise    s.n + metre_weight (d+ + d-) + frame_weight (t+ + t-)
        subject to  d.n - distance = d+ - d-,  t.n - frames = t+ - t-.

    H lists all walks and loops and solves four programmes for each walk; eq. 19 there subtracts the targets once for
    every loop, where only the walk itself may. Counts are those of a path exactly where the arcs in use hang together
    (Euler). Where a solution's do not, each part S that is away from the start is cut off by
    ``n_a <= M_a (sum of n over the arcs into S)`` for its most played arc a, with M_a how often a path that is no worse
    than the one with the fewest frames can play it, and the programme is solved again. What is left is the smallest of
    all.

    Parameters
    ----------
    distance, frames : targets; None leaves a term out. Without ``frames`` 0.001 is paid for each
    exact_frames : ``frames`` must be met, not only nearly
    closed : the path must have at least one arc though start and goal are the same

    Returns
    -------
    None where there is no path (or none of exactly ``frames`` frames).
    """
    if routes.goal is None:
        raise ValueError("routes.goal: expected a node, got None")
    if exact_frames and frames is None:
        raise ValueError("frames: expected a number with exact_frames, got None")
    arcs, count = routes.arcs, len(routes.arcs)
    source, target = (np.array([getattr(arc, end) for arc in arcs], np.int64) for end in ("source", "target"))
    cost = np.array([arc.cost for arc in arcs])
    metres = np.array([arc.distance for arc in arcs]) if distance is not None else np.zeros(count)
    length = np.array([float(arc.frames) for arc in arcs])
    wanted = (distance or 0.0, float(frames or 0))
    if frames is None:
        frame_weight = HASTE
    shortest = _fewest_frames(routes, closed)
    if shortest is None:
        return None
    worst = sum(cost[a] for a in shortest) + metre_weight * abs(metres[shortest].sum() - wanted[0])
    worst += frame_weight * abs(length[shortest].sum() - wanted[1])
    longest = wanted[1] if exact_frames else wanted[1] + worst / frame_weight
    most = np.floor(longest / length + 1e-9)

    # Columns: the arcs, then d+, d-, t+, t-.
    columns, index = count + 4, np.arange(count)
    shape = (len(routes.frames), columns)
    flow = csr_array(coo_array((np.ones(count), (source, index)), shape=shape))
    flow = flow - csr_array(coo_array((np.ones(count), (target, index)), shape=shape))
    balance = np.zeros(len(routes.frames))
    balance[routes.start] += 1
    balance[routes.goal] -= 1
    rows = [np.concatenate([metres, [-1, 1, 0, 0]]), np.concatenate([length, [0, 0, -1, 1]])]
    least, largest = list(wanted), list(wanted)
    if closed:
        rows.append(np.concatenate([source == routes.start, np.zeros(4)]))
        least.append(1)
        largest.append(np.inf)
    slack = np.inf if distance is not None else 0.0
    late = 0.0 if exact_frames else np.inf
    bounds = Bounds(np.zeros(columns), np.concatenate([most, [slack, slack, late, late]]))
    weights = np.concatenate([cost, np.repeat([metre_weight, frame_weight], 2)])
    integrality = np.concatenate([np.ones(count), np.zeros(4)])
    while True:
        found = milp(
            weights,
            constraints=LinearConstraint(
                vstack([flow, csr_array(np.stack(rows))]), np.r_[balance, least], np.r_[balance, largest]
            ),
            bounds=bounds,
            integrality=integrality,
            options={"mip_rel_gap": 0.0},
        )
        if found.x is None:
            return None
        played = np.rint(found.x[:count]).astype(np.int64)
        cuts = _cuts(routes, source, target, played, most)
        if not cuts:
            order = tuple(_euler_path(routes, played))
            walked = float(np.array([arc.distance for arc in arcs]) @ played)
            # From the whole counts, not from the solver's, which are whole to six digits.
            missed = metre_weight * abs(metres @ played - wanted[0]) + frame_weight * abs(length @ played - wanted[1])
            return DistanceTime(order, int(length @ played), walked, float(cost @ played + missed))
        for cut in cuts:
            rows.append(cut)
            least.append(0)
            largest.append(np.inf)


def _fewest_frames(routes: Routes, closed: bool) -> list[int] | None:
    table = LengthTable(routes)
    frames = table.possible(routes.start, 0, int(closed))
    return None if frames is None else table.trace(routes.start, frames)


def _cuts(
    routes: Routes, source: np.ndarray, target: np.ndarray, played: np.ndarray, most: np.ndarray
) -> list[np.ndarray]:
    """A row (>= 0) for every part of the arcs in use that the start does not hang together with."""
    used = np.flatnonzero(played)
    nodes = len(routes.frames)
    joined = coo_array((np.ones(len(used)), (source[used], target[used])), shape=(nodes, nodes))
    _, part = connected_components(joined, directed=False)
    cuts = []
    for away in sorted({int(p) for p in part[source[used]]} - {int(part[routes.start])}):
        inside = part == away
        arc = max((a for a in used if inside[source[a]]), key=lambda a: (played[a], -a))
        row = np.zeros(len(source) + 4)
        row[: len(source)] = most[arc] * (inside[target] & ~inside[source])
        row[arc] -= 1
        cuts.append(row)
    return cuts


def _euler_path(routes: Routes, played: np.ndarray) -> list[int]:
    """An order of the arcs, each ``played`` times, that is a path from the start (Hierholzer)."""
    left = played.copy()
    waiting: list[tuple[int, int]] = [(routes.start, -1)]
    order: list[int] = []
    while waiting:
        node, came_by = waiting[-1]
        way = next((arc for arc in routes.out[node] if left[arc]), None)
        if way is None:
            order.append(came_by)
            waiting.pop()
        else:
            left[way] -= 1
            waiting.append((routes.arcs[way].target, way))
    return order[-2::-1]
