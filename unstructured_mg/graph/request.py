"""What a path is asked for, and the path that comes nearest to it."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.distance_time import solve_distance_time
from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.follow_curve import Curve, follow_curve
from unstructured_mg.graph.motion_graph import MotionGraph
from unstructured_mg.graph.paths import Path, require_frame, shortest_path
from unstructured_mg.graph.pose_times import through_poses
from unstructured_mg.graph.routes import Routes, build_routes
from unstructured_mg.graph.stay_within import stay_within


@dataclass(frozen=True)
class PathRequest:
    """Constraints of a path; those that are None or False do not count.

    Attributes
    ----------
    start, goal : captured frame indices
    frames : frames shown, the first and the last included (of a loop: in one round)
    distance : metres that the body's centre travels over the floor
    curve : (c, 2) float64 metres, the floor curve to follow
    poses : (seconds, captured frame index) in the order of time
    loop : back to where it began
    within : metres that it may get away from its start
    """

    start: int | None = None
    goal: int | None = None
    frames: int | None = None
    distance: float | None = None
    curve: np.ndarray | None = None
    poses: tuple[tuple[float, int], ...] | None = None
    loop: bool = False
    within: float | None = None

    def __post_init__(self) -> None:
        for name, least in (("frames", 1), ("distance", 0), ("within", 0)):
            value = getattr(self, name)
            if value is not None and not least <= value < float("inf"):
                raise ValueError(f"{name}: expected a number from {least} up, got {value}")
        if self.curve is not None and (self.curve.ndim != 2 or self.curve.shape[1] != 2 or len(self.curve) < 2):
            raise ValueError(f"curve: expected two or more points (c, 2), got shape {self.curve.shape}")
        if self.poses is not None:
            times = [time for time, _ in self.poses]
            if len(times) < 2 or times != sorted(times):
                raise ValueError(f"poses: expected two or more in the order of time, got times {times}")


@dataclass(frozen=True)
class FoundPath:
    """The path that comes nearest to a request.

    Attributes
    ----------
    path : what is played
    world : where it begins: the first frame's captured place to the world
    loop : its last frame is its first again
    remark : a sentence or two on how far it is from what was asked for; None where it is exactly that
    """

    path: Path
    world: PlanarRigid
    loop: bool
    remark: str | None


def find_path(graph: MotionGraph, capture: Capture, request: PathRequest) -> FoundPath:
    """The path in the graph that meets a request, or the nearest to it that there is.

    Raises
    ------
    UserError
        Where constraints do not go together, a frame is not in the graph or cannot be reached, or places are wanted
        and the graph has none.
    """
    check_together(request)
    if graph.places is None and (request.distance, request.curve, request.within) != (None, None, None):
        raise UserError("graph.json: says nothing of places on the floor: build the graph again with this program.")
    if request.curve is not None:
        return _along_curve(graph, capture, request)
    if request.poses is not None:
        return _through_poses(graph, capture, request)
    if request.loop:
        return _loop(graph, capture, request)
    assert request.start is not None
    if request.within is not None:
        return _within(build_routes(graph, capture, request.start, request.goal), capture, request)
    assert request.goal is not None
    if request.frames is None and request.distance is None:
        return FoundPath(shortest_path(graph, request.start, request.goal, capture), PlanarRigid(), False, None)
    routes = build_routes(graph, capture, request.start, request.goal)
    if request.distance is not None:
        return _of_distance(routes, capture, request)
    assert request.frames is not None
    return _of_length([routes], capture, request.frames - 1, False)


def check_together(request: PathRequest) -> None:
    """Raise a UserError where a request's constraints do not go together, or too few are given."""
    given = {name: getattr(request, name) not in (None, False) for name in ("goal", "frames", "distance", "loop")}
    given |= {name: getattr(request, name) is not None for name in ("start", "curve", "poses", "within")}
    words = {"start": "--from", "goal": "--to", "frames": "--frames or --seconds"}

    def word(name: str) -> str:
        return words.get(name, f"--{name}")

    allowed = {
        "curve": ({"start"}, "the curve says where the path goes and how far"),
        "poses": (set[str](), "the poses say all"),
        "loop": ({"start", "frames", "distance", "within"}, "a loop ends where it begins"),
        "within": ({"start", "goal", "frames", "loop"}, "leave one of them out"),
    }
    for name, (others, reason) in allowed.items():
        if given[name]:
            wrong = [word(other) for other in given if given[other] and other != name and other not in others]
            if wrong:
                raise UserError(f"{word(name)} and {wrong[0]} do not go together: {reason}.")
    if given["curve"] or given["poses"]:
        return
    missing = []
    if not given["start"] and (not given["loop"] or given["within"] or given["distance"] or not given["frames"]):
        missing.append("start")
    if not given["goal"] and not given["loop"] and not given["within"]:
        missing.append("goal")
    if given["within"] and not given["frames"]:
        missing.append("frames")
    if missing:
        raise UserError(f"a path needs {' and '.join(word(name) for name in missing)}: see umg path --help.")


def _along_curve(graph: MotionGraph, capture: Capture, request: PathRequest) -> FoundPath:
    assert request.curve is not None
    try:
        curve = Curve.through(request.curve)
    except ValueError as error:
        raise UserError(f"the curve: {error}") from None
    starts = [request.start] if request.start is not None else [int(frame) for frame in graph.nodes]
    found = follow_curve([build_routes(graph, capture, start, None) for start in starts], curve)
    if found is None:
        raise UserError(f"No path is as long as the curve, {curve.length:.2f} m: nobody goes anywhere in this graph.")
    remark = (
        f"The path strays from the curve of {curve.length:.2f} m by {100 * found.mean:.0f} cm on average, "
        f"{100 * found.largest:.0f} cm at most."
    )
    return FoundPath(found.routes.path(found.arcs, found.frames), found.world, False, remark)


def _through_poses(graph: MotionGraph, capture: Capture, request: PathRequest) -> FoundPath:
    assert request.poses is not None
    begin = request.poses[0][0]
    wanted = [round((time - begin) * capture.fps) for time, _ in request.poses]
    frames = [frame for _, frame in request.poses]
    for frame in frames:
        require_frame(graph, frame, capture)
    found = through_poses(graph, capture, frames, wanted)
    misses = [
        f"frame {capture.frame_id(frame)} is shown {_off(reached - time, 'frame')}"
        for frame, reached, time in zip(frames, found.times, wanted, strict=True)
        if reached != time
    ]
    remark = f"Nearest to the times asked for: {', '.join(misses)}." if misses else None
    return FoundPath(found.path, PlanarRigid(), False, remark)


def _loop(graph: MotionGraph, capture: Capture, request: PathRequest) -> FoundPath:
    starts = [request.start] if request.start is not None else [int(frame) for frame in graph.nodes]
    routes = [build_routes(graph, capture, start, start) for start in starts]
    if request.within is not None:
        return _within(routes[0], capture, request)
    if request.distance is not None:
        return _of_distance(routes[0], capture, request)
    return _of_length(routes, capture, request.frames, True)


def _of_length(routes: list[Routes], capture: Capture, frames: int | None, loop: bool) -> FoundPath:
    """Of the nearest possible length, of least cost; ``frames`` after the start, None for the fewest."""
    found = []
    for each in routes:
        table = LengthTable(each)
        length = table.possible(each.start, frames or 0, int(loop))
        if length is not None:
            found.append((abs(length - (frames or 0)), float(table.upto(length)[length, each.start]), length, table))
    if not found:
        raise _no_way(routes[0], capture)
    _, _, length, table = min(found, key=lambda entry: entry[:3])
    path = table.routes.path(table.trace(table.routes.start, length))
    remark = None
    if frames is not None and length != frames:
        shown = length if loop else length + 1
        remark = f"The nearest possible length is {shown} frames, {_off(length - frames, 'frame', 'more', 'fewer')}."
    return FoundPath(path, PlanarRigid(), loop, remark)


def _of_distance(routes: Routes, capture: Capture, request: PathRequest) -> FoundPath:
    frames = request.frames
    if frames is not None and not request.loop:
        frames -= 1
    found = solve_distance_time(routes, request.distance, frames, closed=request.loop)
    if found is None:
        raise _no_way(routes, capture)
    assert request.distance is not None
    more = found.distance - request.distance
    remark = f"The path covers {found.distance:.2f} m, {100 * abs(more):.0f} cm {'more' if more > 0 else 'less'} than "
    remark += "was asked for"
    if frames is not None:
        shown = found.frames + (not request.loop)
        off = found.frames - frames
        remark += f", in {shown} frames" + (f", {_off(off, 'frame', 'more', 'fewer')}" if off else "")
    return FoundPath(routes.path(found.arcs), PlanarRigid(), request.loop, remark + ".")


def _within(routes: Routes, capture: Capture, request: PathRequest) -> FoundPath:
    assert request.frames is not None and request.within is not None
    frames = request.frames - (not request.loop)
    length: int | None = frames
    if routes.goal is not None or not routes.graph.cyclic:
        length = LengthTable(routes).possible(routes.start, frames, int(request.loop))
    if length is None:
        raise _no_way(routes, capture)
    found = stay_within(routes, length, request.within)
    if found is None:
        raise _no_way(routes, capture)
    remarks = []
    if length != frames:
        shown = length if request.loop else length + 1
        off = _off(length - frames, "frame", "more", "fewer")
        remarks.append(f"The nearest possible length is {shown} frames, {off}.")
    if found.radius > request.within:
        over = 100 * (found.radius - request.within)
        remarks.append(
            f"The nearest path found gets {found.radius:.2f} m away from its start, {over:.0f} cm more than asked for."
        )
    path = routes.path(found.arcs, length)
    return FoundPath(path, PlanarRigid(), request.loop, " ".join(remarks) or None)


def _no_way(routes: Routes, capture: Capture) -> UserError:
    start = capture.frame_id(int(routes.frames[routes.start]))
    goal = "itself" if routes.goal is None else f"frame {capture.frame_id(int(routes.frames[routes.goal]))}"
    return UserError(
        f"There is no way from frame {start} to {goal}, as no transition leads back in this graph: choose a later "
        "frame of the same run, or build with more transitions."
    )


def _off(amount: int, noun: str, more: str = "too late", less: str = "too early") -> str:
    many = abs(amount)
    return f"{many} {noun}{'s' * (many != 1)} {more if amount > 0 else less}"
