"""Paths through given poses at given times (B section 4)."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.motion_graph import MotionGraph
from unstructured_mg.graph.paths import Path, merged_segments
from unstructured_mg.graph.routes import build_routes


@dataclass(frozen=True)
class PoseTimes:
    """A path through poses.

    Attributes
    ----------
    path : from the first pose to the last
    times : when each pose is reached, frames after the first
    cost : of its transitions
    """

    path: Path
    times: tuple[int, ...]
    cost: float


def through_poses(graph: MotionGraph, capture: Capture, frames: list[int], times: list[int]) -> PoseTimes:
    """The path through captured ``frames`` in their order that misses ``times`` (frames after the first) least.

    Minimises the sum over the poses of |time reached - time wanted|, and of those paths the cost. B solves each pair of
    successive poses by itself, by branch and bound; here best(i, T), the least that reaching pose i at time T costs, is
    min over l of best(i-1, T - l) + cost of the way of exactly l frames + what T misses, so a delay can be made up for
    later and the result is the best there is.

    Raises
    ------
    UserError
        Where a frame is not in the graph or cannot be reached.
    """
    legs = [LengthTable(build_routes(graph, capture, a, b)) for a, b in zip(frames, frames[1:], strict=False)]
    shortest = []
    for leg, goal in zip(legs, frames[1:], strict=True):
        least = leg.possible(leg.routes.start, 0)
        if least is None:
            raise UserError(f"Frame {capture.frame_id(goal)} cannot be reached from the frame before it.")
        shortest.append(least)
    # Nothing is gained by being later than one who takes every way at its shortest and waits nowhere.
    horizon = max([*times, *np.cumsum([0, *shortest]).tolist()]) + max([0, *shortest])
    miss = np.full(horizon + 1, np.inf)
    cost = np.full(horizon + 1, np.inf)
    miss[0], cost[0] = 0, 0
    came: list[np.ndarray] = []
    for leg, wanted in zip(legs, times[1:], strict=True):
        way = leg.upto(horizon)[:, leg.routes.start]
        best_miss, best_cost = np.full(horizon + 1, np.inf), np.full(horizon + 1, np.inf)
        length = np.zeros(horizon + 1, np.int64)
        for frames_played in np.flatnonzero(np.isfinite(way)).tolist():
            before = slice(0, horizon + 1 - frames_played)
            after = slice(frames_played, None)
            reached = miss[before], cost[before] + way[frames_played]
            better = (reached[0] < best_miss[after]) | (
                (reached[0] == best_miss[after]) & (reached[1] < best_cost[after])
            )
            best_miss[after][better] = reached[0][better]
            best_cost[after][better] = reached[1][better]
            length[after][better] = frames_played
        miss, cost = best_miss + np.abs(np.arange(horizon + 1) - wanted), best_cost
        came.append(length)
    last = int(np.lexsort([cost, miss])[0])
    total, reached_at, segments = float(cost[last]), [last], []
    for leg, length in zip(legs[::-1], came[::-1], strict=True):
        played = int(length[reached_at[-1]])
        segments.append(leg.routes.path(leg.trace(leg.routes.start, played)).segments)
        reached_at.append(reached_at[-1] - played)
    merged = merged_segments([segment for part in segments[::-1] for segment in part])
    return PoseTimes(Path(frames[0], frames[-1], merged), tuple(reached_at[::-1]), total)
