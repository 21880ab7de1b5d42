"""Paths that follow a curve on the floor (B section 4)."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.labels import (
    CELL_METRES,
    Labels,
    Trail,
    best_labels,
    join_labels,
    placed,
    poses_after,
    start_labels,
)
from unstructured_mg.graph.routes import Routes

# Partial paths that are followed from each stretch of the curve, and how long a stretch is.
WIDTH, STRETCH_METRES = 400, 0.1
# Headings that are tried at the start, turns from the best one that are tried after it, and how often.
HEADINGS, REFINEMENTS, REPEATS = 24, np.radians([0, -1, 1, -2, 2, -4, 4, -7, 7, -12, 12]), 5
# Arcs that may follow each other without leaving a stretch: standing still is a way on, but no way to stay for ever.
STANDING_ARCS = 12
# More cells than a curve is long.
FAR_APART = 1_000_000_000


@dataclass(frozen=True)
class Curve:
    """A polygon on the floor.

    Attributes
    ----------
    points : (c, 2) float64 metres, c >= 2
    along : (c,) float64 metres from the first point
    """

    points: np.ndarray
    along: np.ndarray

    @classmethod
    def through(cls, points: np.ndarray) -> "Curve":
        """Raises ValueError where the points have no length."""
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if not steps.sum() > 0:
            raise ValueError(f"points: expected two or more different points, got {len(points)} without a length")
        return cls(np.asarray(points, np.float64), np.concatenate([[0], np.cumsum(steps)]))

    @property
    def length(self) -> float:
        return float(self.along[-1])

    def at(self, along: np.ndarray) -> np.ndarray:
        """(..., 2) points at those distances from the first; beyond the ends the ends."""
        return np.stack([np.interp(along, self.along, self.points[:, i]) for i in (0, 1)], axis=-1)


@dataclass(frozen=True)
class Follow:
    """A path along a curve.

    Attributes
    ----------
    routes : from its start
    arcs : in order; the last may be longer than what is left to play
    frames : frames after the start, up to the curve's end
    world : the start's captured place to the curve's
    paid : metres between each frame's place and the curve's point at the same distance along, added up
    mean, largest : of the same
    """

    routes: Routes
    arcs: tuple[int, ...]
    frames: int
    world: PlanarRigid
    paid: float
    mean: float
    largest: float


def follow_curve(starts: list[Routes], curve: Curve, width: int = WIDTH) -> Follow | None:
    """The path from one of the starts that comes nearest to the curve, played until it is as long as the curve.

    Minimises B eq. 8: the sum over the frames of the distance (metres) from where the frame stands to the point of the
    curve that lies as far along it as the frame lies along the path. Where the path begins and how it heads there is
    chosen too.

    Branch and bound over partial paths in the order of how far along they are, ``width`` of them from every stretch of
    10 cm. A partial path is dropped when what it has paid, and the least that it still will, is no less than a whole
    path's: as both the path and its point on the curve move at most v a frame, an error of e lasts, so at least the sum
    of max(0, e - 2 v m), m = 1, 2, ... over the frames that are left must be paid. Paths begin at the curve's first
    point with headings all around; the best is moved by the rigid motion that fits it best, and the search repeated
    from there, with like headings, for as long as that is better. None where no path is long enough.
    """
    best: Follow | None = None
    headings = np.arange(HEADINGS) * 2 * np.pi / HEADINGS
    for routes in starts:
        own = _own_place(routes)
        poses = np.array([_standing(own, curve.points[0], heading) for heading in headings])
        best = _better(best, _search(routes, poses, curve, width, np.inf if best is None else best.paid))
    for _ in range(REPEATS):
        if best is None:
            return None
        own, world = _own_place(best.routes), best.world
        place = placed(np.array([[world.yaw, world.x, world.y]]), own[None])[0, 0]
        poses = np.array([_standing(own, place, world.yaw + turn) for turn in REFINEMENTS])
        again = _better(best, _search(best.routes, poses, curve, width, best.paid))
        if again is best:
            break
        best = again
    return best


def _own_place(routes: Routes) -> np.ndarray:
    if routes.graph.places is None:
        raise ValueError("routes.graph.places: expected places, got None")
    return np.asarray(routes.graph.places.captured[routes.frames[routes.start]])


def _better(one: Follow | None, other: Follow | None) -> Follow | None:
    if one is None or other is None:
        return other if one is None else one
    return other if other.paid < one.paid else one


def _search(routes: Routes, poses: np.ndarray, curve: Curve, width: int, bound: float) -> Follow | None:
    """The best path that starts in one of the ``poses`` (m, 3), if one pays less than ``bound``."""
    assert routes.graph.places is not None
    own = routes.graph.places.captured[routes.frames]
    arcs = routes.arcs
    steps = [_steps(own[arc.source], arc.points) for arc in arcs]
    fastest = max((float(step.max()) for step in steps), default=0.0)
    # Worth: the sum of errors, and how far along.
    trail = Trail()
    stretches = int(np.ceil(curve.length / STRETCH_METRES))
    waiting: list[dict[int, list[Labels]]] = [{} for _ in range(stretches)]
    waiting[0][routes.start] = [start_labels(poses, 2)]
    ends: list[Labels] = []
    for stretch in range(stretches):
        for _ in range(STANDING_ARCS):
            here, waiting[stretch] = waiting[stretch], {}
            if not here:
                break
            nodes = np.concatenate([np.full(sum(map(len, parts)), node) for node, parts in sorted(here.items())])
            labels = join_labels([part for _, parts in sorted(here.items()) for part in parts])
            shown = _own_places(labels.pose, own[nodes])
            error = np.linalg.norm(shown - curve.at(labels.worth[:, 1]), axis=1)
            least = labels.worth[:, 0] + still_to_pay(error, curve.length - labels.worth[:, 1], fastest)
            open_ = np.flatnonzero(least < bound)
            if not len(open_):
                continue
            rows, here_along = labels.take(open_), labels.worth[open_, 1]
            group = nodes[open_] * FAR_APART + np.rint(here_along / CELL_METRES).astype(np.int64)
            kept = open_[best_labels(rows, least[open_, None], group, width)]
            labels, nodes = labels.take(kept), nodes[kept]
            parent = trail.add(labels)
            for node in np.unique(nodes):
                mine = nodes == node
                part = labels.take(np.flatnonzero(mine))
                for index in routes.out[node]:
                    arc = arcs[index]
                    assert arc.points is not None
                    along = part.worth[:, 1:] + np.cumsum(steps[index])
                    errors = np.linalg.norm(placed(part.pose, arc.points) - curve.at(along), axis=2)
                    whole = along[:, -1] >= curve.length
                    # A whole path stops with the frame that reaches the curve's end.
                    last = np.where(whole, np.argmax(along >= curve.length, axis=1), arc.frames - 1)
                    paid = part.worth[:, 0] + np.cumsum(errors, axis=1)[np.arange(len(part)), last]
                    grown = Labels(
                        poses_after(part.pose, arc.motion),
                        np.column_stack([paid, along[:, -1]]),
                        part.frames + last + 1,
                        parent[mine],
                        np.full(len(part), index, np.int64),
                    )
                    if whole.any():
                        ends.append(grown.take(np.flatnonzero(whole)))
                        bound = min(bound, float(ends[-1].worth[:, 0].min()))
                    on = np.flatnonzero(~whole & (paid < bound))
                    place = np.minimum((along[on, -1] / STRETCH_METRES).astype(np.int64), stretches - 1)
                    for to in np.unique(place):
                        rows_there = grown.take(on[place == to])
                        waiting[to].setdefault(arc.target, []).append(rows_there)
    if not ends:
        return None
    done = join_labels(ends)
    best = int(np.argmin(done.worth[:, 0]))
    order = trail.arcs(int(done.parent[best]), int(done.arc[best]))
    return _fitted(routes, order, int(done.frames[best]), curve)


def still_to_pay(error: np.ndarray, left: np.ndarray, fastest: float) -> np.ndarray:
    """(m,): the least sum of errors that is still to come for paths that are ``error`` (m,) metres off and have
    ``left`` (m,) metres to go, when no frame moves by more than ``fastest`` metres."""
    if fastest == 0:
        return np.zeros_like(error)
    frames = np.floor(np.minimum(error / (2 * fastest), left / fastest))
    return np.asarray(frames * error - fastest * frames * (frames + 1))


def _standing(own: np.ndarray, place: np.ndarray, yaw: float) -> np.ndarray:
    """The pose that turns by ``yaw`` and puts ``own`` on ``place``."""
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([yaw, place[0] - c * own[0] + s * own[1], place[1] - s * own[0] - c * own[1]])


def _steps(first: np.ndarray, points: np.ndarray | None) -> np.ndarray:
    """(f,) metres from each point to the next, beginning with (2,) ``first``."""
    assert points is not None
    return np.asarray(np.linalg.norm(np.diff(np.concatenate([first[None], points]), axis=0), axis=1))


def _own_places(pose: np.ndarray, own: np.ndarray) -> np.ndarray:
    c, s = np.cos(pose[:, 0]), np.sin(pose[:, 0])
    return np.column_stack([c * own[:, 0] - s * own[:, 1] + pose[:, 1], s * own[:, 0] + c * own[:, 1] + pose[:, 2]])


def _fitted(routes: Routes, order: list[int], frames: int, curve: Curve) -> Follow:
    """The path under the rigid motion with the least sum of squared distances to the curve."""
    assert routes.graph.places is not None
    pose, points = np.zeros((1, 3)), [routes.graph.places.captured[routes.frames[routes.start]][None]]
    for index in order:
        arc = routes.arcs[index]
        assert arc.points is not None
        points.append(placed(pose, arc.points)[0])
        pose = poses_after(pose, arc.motion)
    path = np.concatenate(points)[: frames + 1]
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    wanted = curve.at(along)
    yaw = _turn(path - path.mean(axis=0), wanted - wanted.mean(axis=0))
    world = PlanarRigid(*_standing(path.mean(axis=0), wanted.mean(axis=0), yaw))
    errors = np.linalg.norm(placed(np.array([[world.yaw, world.x, world.y]]), path)[0] - wanted, axis=1)
    paid, mean, largest = float(errors.sum()), float(errors.mean()), float(errors.max())
    return Follow(routes, tuple(order), frames, world, paid, mean, largest)


def _turn(points: np.ndarray, wanted: np.ndarray) -> float:
    """The yaw that turns (m, 2) points onto wanted ones best, both about the origin."""
    crossed = points[:, 0] * wanted[:, 1] - points[:, 1] * wanted[:, 0]
    return float(np.arctan2(crossed.sum(), (points * wanted).sum()))
