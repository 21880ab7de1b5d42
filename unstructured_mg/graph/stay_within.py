"""Paths of an exact length that stay within a radius of where they begin."""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.labels import Labels, Trail, best_labels, join_labels, placed, poses_after, start_labels
from unstructured_mg.graph.routes import Routes

# Partial paths that are followed from one node at one time.
WIDTH = 128


@dataclass(frozen=True)
class Stay:
    """A path that stays near its start.

    Attributes
    ----------
    arcs : the path's arcs in order; without a goal the last may be longer than what is left to play
    frames : frames after the start
    radius : metres: the farthest that it gets from its first frame's place
    cost : of its transitions
    """

    arcs: tuple[int, ...]
    frames: int
    radius: float
    cost: float


def stay_within(routes: Routes, frames: int, radius: float, width: int = WIDTH) -> Stay | None:
    """The path of ``frames`` frames after the start that leaves the circle least, and of those the one of least cost.

    Partial paths are made in the order of their frames. Bounds that prune: one that has less left than its way to the
    goal, or of a length that no way to the goal has, is dropped (``LengthTable``); of the others each node at each
    time keeps the ``width`` best by distance outside so far, cost with the least cost of the way that is left, and
    distance from the start. None where no path has the length.
    """
    graph = routes.graph
    if graph.places is None:
        raise ValueError("routes.graph.places: expected places, got None")
    centre = graph.places.captured[routes.frames[routes.start]]
    left = LengthTable(routes).upto(frames)
    if not np.isfinite(left[frames, routes.start]):
        return None
    trail = Trail()
    waiting: dict[int, dict[int, list[Labels]]] = defaultdict(lambda: defaultdict(list))
    waiting[0][routes.start].append(start_labels(np.zeros((1, 3)), 2))
    ends: list[Labels] = []
    for time in range(frames):
        for node, parts in sorted(waiting.pop(time, {}).items()):
            labels = join_labels(parts)
            own = placed(labels.pose, graph.places.captured[routes.frames[node]][None])[:, 0]
            away = np.linalg.norm(own - centre, axis=1)
            to_go = labels.worth[:, 1] + left[frames - time, node]
            rank = np.column_stack([labels.worth[:, 0], to_go, away])
            labels = labels.take(best_labels(labels, rank, np.zeros(len(labels)), width))
            parent = trail.add(labels)
            for index in routes.out[node]:
                arc = routes.arcs[index]
                after = time + arc.frames
                if routes.goal is not None and (after > frames or not np.isfinite(left[frames - after, arc.target])):
                    continue
                assert arc.points is not None
                shown = placed(labels.pose, arc.points[: frames - time]) - centre
                farthest = np.linalg.norm(shown, axis=2).max(axis=1)
                outside = np.maximum(labels.worth[:, 0], np.maximum(farthest - radius, 0))
                grown = Labels(
                    poses_after(labels.pose, arc.motion),
                    np.column_stack([outside, labels.worth[:, 1] + arc.cost]),
                    np.full(len(labels), min(after, frames), np.int64),
                    parent,
                    np.full(len(labels), index, np.int64),
                )
                if after >= frames:
                    ends.append(grown)
                else:
                    waiting[after][arc.target].append(grown)
    if frames == 0:
        return Stay((), 0, 0.0, 0.0)
    done = join_labels(ends)
    best = int(np.lexsort([done.worth[:, 1], done.worth[:, 0]])[0])
    arcs = trail.arcs(int(done.parent[best]), int(done.arc[best]))
    reached = _radius(routes, arcs, frames, centre)
    return Stay(tuple(arcs), frames, reached, float(done.worth[best, 1]))


def _radius(routes: Routes, arcs: list[int], frames: int, centre: np.ndarray) -> float:
    pose, points = np.zeros((1, 3)), []
    for index in arcs:
        arc = routes.arcs[index]
        assert arc.points is not None
        points.append(placed(pose, arc.points)[0])
        pose = poses_after(pose, arc.motion)
    return float(np.linalg.norm(np.concatenate(points)[:frames] - centre, axis=1).max())
