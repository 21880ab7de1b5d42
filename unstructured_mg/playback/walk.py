"""Walks through the graph: which frame is shown when, and where in the world (P section 7)."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.motion_graph import MotionGraph, Segment
from unstructured_mg.graph.paths import cut_segments, locate_frame, require_frame
from unstructured_mg.graph.request import PathRequest, find_path
from unstructured_mg.playback.random_generator import MASK, RandomGenerator


@dataclass(frozen=True)
class WalkFrame:
    """One shown frame: a captured one, or one step of a transition.

    Attributes
    ----------
    source : "capture" or "transition"
    frame : captured frame index, or None
    transition : (source, target) frame indices, or None
    step : -k+1 .. k-1, or None
    world : the frame's own place (of a transition: its source's captured place) to the world; metres, z up
    """

    source: str
    frame: int | None
    transition: tuple[int, int] | None
    step: int | None
    world: PlanarRigid

    @property
    def content(self) -> tuple[int, ...]:
        """What is shown, wherever: the captured frame's index, or the transition's source and target and the step."""
        if self.transition is not None and self.step is not None:
            return (*self.transition, self.step)
        assert self.frame is not None
        return (self.frame,)


@dataclass(frozen=True)
class Walk:
    """Shown frames in order.

    Attributes
    ----------
    frames : tuple of WalkFrame
    kind : "random", "path", "loop" or "capture"
    seed : of a random walk, else None
    start : captured frame index
    goal : captured frame index that a path ends with; None where it ends inside a transition, of a loop or random walk
    ended : why a random walk is shorter than was asked for, a sentence; None where it is not
    remark : how far a path is from what was asked for, a sentence or two; None where it is exactly that
    again : of a loop, where its first frame goes when it is played once more: the frame's own place to the world
    """

    frames: tuple[WalkFrame, ...]
    kind: str
    seed: int | None
    start: int
    goal: int | None
    ended: str | None
    remark: str | None = None
    again: PlanarRigid | None = None

    def __len__(self) -> int:
        return len(self.frames)

    def __iter__(self) -> Iterator[WalkFrame]:
        return iter(self.frames)


def random_walk(graph: MotionGraph, capture: Capture, frames: int, seed: int, start: int | None = None) -> Walk:
    """``frames`` frames from captured frame ``start``, with the graph's probabilities (P section 7.1).

    Without ``start`` it begins at the graph's first frame, or, in a graph without cycles, with the longest run.
    A graph without cycles has walks that end: ``ended`` then says where.

    Raises
    ------
    UserError
        Where ``start`` is not in the graph, ``seed`` is not 0 to 2^32 - 1, or ``frames`` is not positive.
    """
    if frames < 1:
        raise UserError(f"A walk of {frames} frames was asked for: ask for at least one.")
    if not 0 <= seed <= MASK:
        raise UserError(f"Seed {seed} is out of range: choose a whole number from 0 to {MASK}.")
    if start is None:
        start = default_start(graph, capture)
    require_frame(graph, start, capture)
    played = tuple(islice(endless_walk(graph, seed, start), frames))
    ended = None
    if len(played) < frames:
        last = capture.frame_id(int(played[-1].frame or 0))
        ended = f"The walk ends after {len(played)} frames at frame {last}, where the graph has no way on."
    return Walk(played, "random", seed, start, None, ended)


def path_walk(graph: MotionGraph, capture: Capture, request: PathRequest) -> Walk:
    """The path that comes nearest to a request (P section 7.2; H and B section 4), from its first frame to its last.

    A loop's last frame is its first again and is not shown twice.

    Raises
    ------
    UserError
        As ``find_path``.
    """
    found = find_path(graph, capture, request)
    path = found.path
    first = WalkFrame("capture", path.start, None, None, found.world)
    frames = (first, *_play(graph, path.segments, found.world))
    if found.loop:
        return Walk(frames[:-1], "loop", None, path.start, None, None, found.remark, frames[-1].world)
    return Walk(frames, "path", None, path.start, frames[-1].frame, None, found.remark)


def capture_walk(capture: Capture) -> Walk:
    """The captured frames as they are: all of them in order, each in its own place."""
    frames = tuple(WalkFrame("capture", index, None, None, PlanarRigid()) for index in range(len(capture)))
    return Walk(frames, "capture", None, 0, None, None)


def endless_walk(graph: MotionGraph, seed: int, start: int) -> Iterator[WalkFrame]:
    """The frames of a random walk for as long as there is a way on, one at a time.

    At each node with several out-edges one number is drawn and compared with the integer thresholds, so that the walk
    is the same in every player (docs/files.md).
    """
    yield WalkFrame("capture", start, None, None, PlanarRigid())
    yield from _play(graph, endless_segments(graph, seed, start), PlanarRigid())


def endless_segments(graph: MotionGraph, seed: int, start: int) -> Iterator[Segment]:
    """What a random walk plays after captured frame ``start``, for as long as there is a way on."""
    generator, ways = RandomGenerator(seed), graph.out_edges()
    node, inside, place = locate_frame(graph, start)
    if inside is not None:
        edge = graph.edges[inside]
        yield from cut_segments(edge.segments, place + 1, len(edge))
        node = edge.target
    while ways[node]:
        edge = graph.edges[_choose(graph, ways[node], generator)]
        yield from edge.segments
        node = edge.target


def _choose(graph: MotionGraph, ways: list[int], generator: RandomGenerator) -> int:
    if len(ways) == 1:
        return ways[0]
    drawn = generator.draw()
    return next(edge for edge in ways if drawn <= graph.thresholds[edge])


def _play(graph: MotionGraph, segments: Iterable[Segment], world: PlanarRigid) -> Iterator[WalkFrame]:
    for segment in segments:
        if segment.link is None:
            for frame in range(segment.first, segment.last + 1):
                yield WalkFrame("capture", frame, None, None, world)
        else:
            link = graph.links[segment.link]
            for step in range(segment.first, segment.last + 1):
                yield WalkFrame("transition", None, (link.source, link.target), step, world)
            # Steps lie in the source's place, the frames that follow in the target's.
            moved = world.after(link.alignment)
            world = PlanarRigid(math.remainder(moved.yaw, math.tau), moved.x, moved.y)


def default_start(graph: MotionGraph, capture: Capture) -> int:
    if graph.cyclic:
        return int(graph.frames[0])
    return max(capture.runs(), key=lambda run: (len(run), -run.start)).start
