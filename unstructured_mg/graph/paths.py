"""Shortest paths between captured frames (P section 7.2)."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.graph.frame_ranges import frame_ranges
from unstructured_mg.graph.motion_graph import MotionGraph, Segment


@dataclass(frozen=True)
class Path:
    """What is played from one captured frame to another.

    Attributes
    ----------
    start, goal : captured frame indices; the goal is None where the path stops inside a transition
    segments : what is played after ``start``, up to and including ``goal``; empty where they are the same
    """

    start: int
    goal: int | None
    segments: tuple[Segment, ...]

    def __len__(self) -> int:
        """Frames played after ``start``."""
        return sum(len(segment) for segment in self.segments)


def shortest_path(
    graph: MotionGraph, start_frame: int, goal_frame: int, capture: Capture, cost_weight: float = 0.0
) -> Path:
    """The path with the fewest frames, synthesized ones included, by Dijkstra's algorithm.

    With a ``cost_weight`` (frames per unit of cost) the sum of frames and weighted costs of transitions is smallest.
    Of equally short paths the one with fewer transitions is taken. ``capture`` only names frames.

    Raises
    ------
    UserError
        Where a frame is not in the graph, or (in a graph without cycles) there is no way.
    """
    for frame in (start_frame, goal_frame):
        require_frame(graph, frame, capture)
    start_node, start_edge, start_place = locate_frame(graph, start_frame)
    goal_node, goal_edge, goal_place = locate_frame(graph, goal_frame)
    if start_frame == goal_frame:
        return Path(start_frame, goal_frame, ())
    if start_edge is not None and start_edge == goal_edge and start_place < goal_place:
        between = cut_segments(graph.edges[start_edge].segments, start_place + 1, goal_place + 1)
        return Path(start_frame, goal_frame, between)
    # From inside an edge the only way is on to its end; to inside an edge the only way is from its beginning.
    lead_in: tuple[Segment, ...] = ()
    if start_edge is not None:
        edge = graph.edges[start_edge]
        lead_in, start_node = cut_segments(edge.segments, start_place + 1, len(edge)), edge.target
    lead_out: tuple[Segment, ...] = ()
    if goal_edge is not None:
        edge = graph.edges[goal_edge]
        lead_out, goal_node = cut_segments(edge.segments, 0, goal_place + 1), edge.source
    middle = _dijkstra(graph, start_node, goal_node, cost_weight)
    if middle is None:
        raise UserError(
            f"Frame {capture.frame_id(goal_frame)} cannot be reached from frame {capture.frame_id(start_frame)}, as no "
            "transition leads back in this graph: choose a later frame of the same run, or build with more transitions."
        )
    segments = [s for index in middle for s in graph.edges[index].segments]
    return Path(start_frame, goal_frame, merged_segments([*lead_in, *segments, *lead_out]))


def require_frame(graph: MotionGraph, frame: int, capture: Capture) -> None:
    """Raise a UserError that lists the graph's frames where ``frame`` (an index) is not among them."""
    if frame not in graph.frames:
        raise UserError(
            f"Frame {capture.frame_id(frame)} is not in the motion graph, whose largest strongly connected part holds "
            f"{len(graph.frames)} frames: choose one of {frame_ranges(graph.frames, capture)}."
        )


def locate_frame(graph: MotionGraph, frame: int) -> tuple[int, int | None, int]:
    """(node, None, 0) of a node's frame, or (-1, edge, place among the edge's frames)."""
    node = int(np.searchsorted(graph.nodes, frame))
    if node < len(graph.nodes) and graph.nodes[node] == frame:
        return node, None, 0
    for index, edge in enumerate(graph.edges):
        place = 0
        for segment in edge.segments:
            if segment.link is None and segment.first <= frame <= segment.last:
                return -1, index, place + frame - segment.first
            place += len(segment)
    raise ValueError(f"frame: expected a frame of the graph, got {frame}")


def cut_segments(segments: tuple[Segment, ...], start: int, stop: int) -> tuple[Segment, ...]:
    """Frames start .. stop-1 of what the segments play; only captured segments are ever cut."""
    part, place = [], 0
    for segment in segments:
        first, last = max(start - place, 0), min(stop - place, len(segment)) - 1
        if first <= last:
            part.append(Segment(segment.link, segment.first + first, segment.first + last))
        place += len(segment)
    return tuple(part)


def merged_segments(segments: Sequence[Segment]) -> tuple[Segment, ...]:
    """The same frames with captured segments that follow each other without a break as one."""
    merged: list[Segment] = []
    for segment in segments:
        before = merged[-1] if merged else None
        if before is not None and before.link is None and segment.link is None and before.last + 1 == segment.first:
            merged[-1] = Segment(None, before.first, segment.last)
        else:
            merged.append(segment)
    return tuple(merged)


def _dijkstra(graph: MotionGraph, start: int, goal: int, cost_weight: float) -> list[int] | None:
    """Edges from node to node, or None. Equal lengths go to fewer transitions, then to lower edge indices."""
    ways = graph.out_edges()
    best: dict[int, tuple[float, int]] = {start: (0.0, 0)}
    came_by: dict[int, int] = {}
    queue = [(0.0, 0, start)]
    while queue:
        length, transitions, node = heapq.heappop(queue)
        if (length, transitions) != best[node]:
            continue
        if node == goal:
            break
        for index in ways[node]:
            edge = graph.edges[index]
            used = [s.link for s in edge.segments if s.link is not None]
            cost = cost_weight * sum(graph.links[link].cost for link in used)
            reached = (length + len(edge) + cost, transitions + len(used))
            if edge.target not in best or reached < best[edge.target]:
                best[edge.target], came_by[edge.target] = reached, index
                heapq.heappush(queue, (*reached, edge.target))
    if goal not in best:
        return None
    path: list[int] = []
    node = goal
    while node != start:
        path.append(came_by[node])
        node = graph.edges[path[-1]].source
    return path[::-1]
