"""What can be played: an endless walk that can be directed, the capture as it is, a transition between its neighbours.

All of them give ``frame(index)``; the page's reels.js shows the same frames.
"""

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, cycle

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.motion_graph import MotionGraph, Segment
from unstructured_mg.graph.paths import shortest_path
from unstructured_mg.graph.request import PathRequest, find_path
from unstructured_mg.playback.walk import WalkFrame, endless_segments

# Runs of captured frames and transitions that a walk keeps to be scrubbed back through.
KEPT = 4096


@dataclass(frozen=True)
class _Block:
    """A segment at its place in a walk: the index of its first frame, and the world motion that it is shown at."""

    at: int
    segment: Segment
    world: PlanarRigid

    @property
    def stop(self) -> int:
        return self.at + len(self.segment)


class WalkReel:
    """A walk from captured frame ``start``, at random with ``seed`` until it is directed.

    Attributes
    ----------
    first, known : indices of the first frame that is kept, and after the last one that is known so far
    ended : whether there is none after those
    """

    def __init__(self, graph: MotionGraph, capture: Capture, seed: int, start: int):
        self.graph, self.capture, self.seed = graph, capture, seed
        self.ended = False
        self._blocks = [_Block(0, Segment(None, start, start), PlanarRigid())]
        self._ahead: Iterator[Segment] = endless_segments(graph, seed, start)

    @property
    def first(self) -> int:
        return self._blocks[0].at

    @property
    def known(self) -> int:
        return self._blocks[-1].stop

    def frame(self, index: int) -> WalkFrame | None:
        """What is shown at ``index``, or None before what is kept and after the walk's end."""
        while index >= self.known and not self.ended:
            self._extend()
        if not self.first <= index < self.known:
            return None
        block = self._blocks[self._block_of(index)]
        number = block.segment.first + index - block.at
        if block.segment.link is None:
            return WalkFrame("capture", number, None, None, block.world)
        link = self.graph.links[block.segment.link]
        return WalkFrame("transition", None, (link.source, link.target), number, block.world)

    def go_to(self, index: int, goal: int) -> int:
        """Walk on from what is shown at ``index`` to captured frame ``goal`` the shortest way; on from there at random.

        The random part is ``umg walk --start GOAL`` with the same seed. Returns the index at which the goal is shown.

        Raises
        ------
        UserError
            Where no walk leads there.
        """
        turn, begin = self._turning_point(index)
        path = shortest_path(self.graph, begin, goal, self.capture)
        self._continue(turn, chain(path.segments, endless_segments(self.graph, self.seed, goal)))
        return turn + len(path)

    def loop_from(self, index: int) -> None:
        """Repeat the shortest loop through what is shown at ``index`` for ever. UserError where no way leads back."""
        turn, begin = self._turning_point(index)
        found = find_path(self.graph, self.capture, PathRequest(begin, loop=True))
        self._continue(turn, cycle(found.path.segments))

    def wander_from(self, index: int) -> None:
        """Walk on at random from what is shown at ``index``."""
        turn, begin = self._turning_point(index)
        self._continue(turn, endless_segments(self.graph, self.seed, begin))

    def _turning_point(self, index: int) -> tuple[int, int]:
        """The first index, from ``index`` on, that shows a captured frame, and that frame."""
        while (shown := self.frame(index)) is not None:
            if shown.frame is not None:
                return index, shown.frame
            index += 1
        raise UserError("The walk ends before it comes to a captured frame.")

    def _continue(self, index: int, segments: Iterator[Segment]) -> None:
        at = self._block_of(index)
        block = self._blocks[at]
        last = block.segment.first + index - block.at
        self._blocks[at:] = [replace(block, segment=replace(block.segment, last=last))]
        self._ahead, self.ended = segments, False

    def _extend(self) -> None:
        segment = next(self._ahead, None)
        if segment is None:
            self.ended = True
            return
        last = self._blocks[-1]
        world = last.world
        if last.segment.link is not None:
            moved = world.after(self.graph.links[last.segment.link].alignment)
            world = PlanarRigid(math.remainder(moved.yaw, math.tau), moved.x, moved.y)
        self._blocks.append(_Block(last.stop, segment, world))
        del self._blocks[:-KEPT]

    def _block_of(self, index: int) -> int:
        return bisect_right(self._blocks, index, key=lambda block: block.at) - 1


class FixedReel:
    """So many frames, and no more."""

    ended = True
    first = 0

    def __init__(self, frames: Sequence[WalkFrame]):
        self.frames = tuple(frames)

    @property
    def known(self) -> int:
        return len(self.frames)

    def frame(self, index: int) -> WalkFrame | None:
        """What is shown at ``index``, or None outside."""
        return self.frames[index] if 0 <= index < len(self.frames) else None


def transition_reel(graph: MotionGraph, capture: Capture, link: int, context: int) -> tuple[FixedReel, tuple[int, int]]:
    """A transition between up to ``context`` captured frames on each side, in its source's place.

    Also the indices of the last frame before each seam.
    """
    own = graph.links[link]
    runs = capture.runs()
    before, after = (next(run for run in runs if frame in run) for frame in (own.leaves, own.arrives))
    frames = [
        WalkFrame("capture", frame, None, None, PlanarRigid())
        for frame in range(max(own.leaves - context + 1, before.start), own.leaves + 1)
    ]
    seams = len(frames) - 1, len(frames) + len(own.steps) - 1
    frames += [WalkFrame("transition", None, (own.source, own.target), step, PlanarRigid()) for step in own.steps]
    frames += [
        WalkFrame("capture", frame, None, None, own.alignment)
        for frame in range(own.arrives, min(own.arrives + context, after.stop))
    ]
    return FixedReel(frames), seams
