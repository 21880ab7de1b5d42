"""From one captured frame to another as arcs between nodes: what every path solver works on."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.floor_track import floor_track, track_length
from unstructured_mg.graph.motion_graph import MotionGraph, Segment
from unstructured_mg.graph.paths import Path, cut_segments, locate_frame, merged_segments, require_frame


@dataclass(frozen=True)
class Arc:
    """A way between two nodes of ``Routes`` without a choice on it.

    Attributes
    ----------
    source, target : nodes
    segments : what is played after the source's frame, up to and including the target's
    frames : how many frames these are
    cost : of the transitions among them (``Link.cost`` added up)
    points : (frames, 2) float64 where they stand on the floor, metres, in the source's captured place; None where the
        graph has no places
    distance : metres from the source's frame to the target's along them; nan alike
    motion : the target's captured place to the source's
    """

    source: int
    target: int
    segments: tuple[Segment, ...]
    frames: int
    cost: float
    points: np.ndarray | None
    distance: float
    motion: PlanarRigid


@dataclass(frozen=True)
class Routes:
    """All ways from captured frame ``start_frame`` to ``goal_frame``.

    Nodes 0 to N-1 are the graph's. A start or goal inside an edge is a node of its own behind them; from such a start
    the only way is on to the edge's end, to such a goal from the edge's beginning.

    Attributes
    ----------
    frames : (nodes,) int32, each node's captured frame
    arcs : ordered by source
    start, goal : nodes; the goal is None where any frame may be the last
    """

    graph: MotionGraph
    frames: np.ndarray
    arcs: tuple[Arc, ...]
    start: int
    goal: int | None

    @cached_property
    def out(self) -> list[list[int]]:
        """For each node its arcs, ascending."""
        ways: list[list[int]] = [[] for _ in self.frames]
        for index, arc in enumerate(self.arcs):
            ways[arc.source].append(index)
        return ways

    def path(self, arcs: Sequence[int], frames: int | None = None) -> Path:
        """The frames that ``arcs``, one after the other from the start, play; only the first ``frames`` where given."""
        segments = tuple(segment for index in arcs for segment in self.arcs[index].segments)
        if frames is not None:
            segments = cut_segments(segments, 0, frames)
        start = int(self.frames[self.start])
        goal = segments[-1].last if segments and segments[-1].link is None else None
        return Path(start, goal if segments else start, merged_segments(segments))


def build_routes(graph: MotionGraph, capture: Capture, start_frame: int, goal_frame: int | None) -> Routes:
    """The arcs from ``start_frame`` to ``goal_frame`` (or, where that is None, to anywhere).

    Raises
    ------
    UserError
        Where a frame is not in the graph.
    """
    nodes = [int(frame) for frame in graph.nodes]
    ways: list[tuple[int, int, tuple[Segment, ...]]] = [(e.source, e.target, e.segments) for e in graph.edges]
    require_frame(graph, start_frame, capture)
    start, start_edge, start_place = locate_frame(graph, start_frame)
    if start_edge is not None:
        edge = graph.edges[start_edge]
        start = len(nodes)
        nodes.append(start_frame)
        ways.append((start, edge.target, cut_segments(edge.segments, start_place + 1, len(edge))))
    goal = None
    if goal_frame is not None:
        require_frame(graph, goal_frame, capture)
        goal, goal_edge, goal_place = locate_frame(graph, goal_frame)
        if goal_edge is not None:
            edge = graph.edges[goal_edge]
            goal = start
            if goal_frame != start_frame:
                goal = len(nodes)
                nodes.append(goal_frame)
            ways.append((edge.source, goal, cut_segments(edge.segments, 0, goal_place + 1)))
            if start_edge == goal_edge and start_place < goal_place:
                ways.append((start, goal, cut_segments(edge.segments, start_place + 1, goal_place + 1)))
    ways.sort(key=lambda way: way[0])
    return Routes(graph, np.array(nodes, np.int32), tuple(_arc(graph, nodes, *way) for way in ways), start, goal)


def _arc(graph: MotionGraph, nodes: list[int], source: int, target: int, segments: tuple[Segment, ...]) -> Arc:
    frames = sum(len(segment) for segment in segments)
    # A cut never leaves out a transition's end: the cost is paid once, where it is played.
    cost = sum(graph.links[segment.link].cost for segment in segments if segment.link is not None)
    if graph.places is not None:
        points, motion = floor_track(graph.places, graph.links, segments)
        distance = track_length(np.concatenate([graph.places.captured[nodes[source]][None], points]))
        return Arc(source, target, segments, frames, cost, points, distance, motion)
    motion = PlanarRigid()
    for segment in segments:
        if segment.link is not None:
            motion = motion.after(graph.links[segment.link].alignment)
    return Arc(source, target, segments, frames, cost, None, float("nan"), motion)
