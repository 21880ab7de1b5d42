"""The motion graph: strongly connected, contracted, with probabilities (P section 7)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.flows import optimise_flows
from unstructured_mg.graph.frame_graph import FrameGraph, build_frame_graph, largest_loop
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.places import Places
from unstructured_mg.graph.probabilities import Traffic, even_probabilities, optimise_probabilities, thresholds
from unstructured_mg.graph.targets import target_weights
from unstructured_mg.graph.uniformity import Obstacle, find_obstacles

PROBABILITIES = {"choice": optimise_probabilities, "entropy": optimise_flows}


@dataclass(frozen=True)
class Segment:
    """Frames that are played one after the other.

    Attributes
    ----------
    link : index into the graph's links, or None for captured frames
    first, last : captured frame indices, or the link's steps -k+1 and k-1; both are played
    """

    link: int | None
    first: int
    last: int

    def __len__(self) -> int:
        return self.last - self.first + 1


@dataclass(frozen=True)
class Edge:
    """A way between two nodes without any choice on it.

    Attributes
    ----------
    source, target : node indices
    segments : what is played after the source node's frame, up to and including the target node's frame
    transform : the target node's captured place to the source node's: what the world transform is multiplied by
    """

    source: int
    target: int
    segments: tuple[Segment, ...]
    transform: PlanarRigid

    def __len__(self) -> int:
        """Frames played."""
        return sum(len(segment) for segment in self.segments)

    def inner_frames(self) -> list[int]:
        """The captured frames between the two nodes, in the order in which they are played."""
        frames = [f for s in self.segments if s.link is None for f in range(s.first, s.last + 1)]
        return frames[:-1]


@dataclass(frozen=True)
class MotionGraph:
    """What playback needs. A frame of the graph is either a node's frame or lies inside exactly one edge.

    Attributes
    ----------
    frames : (c,) int32, the captured frames in the graph, ascending
    links : every link, by source and target; those that no edge plays lie outside the strongly connected part
    nodes : (N,) int32, each node's captured frame, ascending
    edges : by source node; the captured way on first, then the links in their order
    probabilities : (E,) float64, summing to one over each node's out-edges
    thresholds : (E,) uint32, cumulative: a drawn number takes the node's first out-edge with at least that threshold
    cyclic : False where no link closes a loop; the graph then holds the whole capture and a walk through it ends
    visits_even : (c,) float64, each captured frame's share of a long walk's captured frames with even choices, or None
        where the graph is not cyclic
    visits : the same with ``probabilities`` (P Fig. 10)
    obstacles : why no probabilities at all can make the visits exactly as wanted; empty where some can
    places : where every frame stands on the floor; None where that was not measured
    """

    frames: np.ndarray
    links: tuple[Link, ...]
    nodes: np.ndarray
    edges: tuple[Edge, ...]
    probabilities: np.ndarray
    thresholds: np.ndarray
    cyclic: bool
    visits_even: np.ndarray | None
    visits: np.ndarray | None
    obstacles: tuple[Obstacle, ...]
    places: Places | None = None

    def out_edges(self) -> list[list[int]]:
        """For each node the indices of its out-edges, ascending."""
        ways: list[list[int]] = [[] for _ in self.nodes]
        for index, edge in enumerate(self.edges):
            ways[edge.source].append(index)
        return ways

    def links_used(self) -> frozenset[int]:
        """The links that some edge plays."""
        return frozenset(s.link for edge in self.edges for s in edge.segments if s.link is not None)


def build_graph(
    capture: Capture, links: Sequence[Link], options: GraphOptions | None = None, places: Places | None = None
) -> MotionGraph:
    """Trim to the largest strongly connected part, contract, and choose probabilities (P section 7, 7.1).

    The order of ``links`` does not matter (that of ``places.steps`` is theirs). Where no cycle exists the graph keeps
    everything and says so (``cyclic``).

    Raises
    ------
    ValueError
        Where a link's windows do not fit into the capture's runs, or two links join the same source and target.
    """
    options = options or GraphOptions()
    order = sorted(range(len(links)), key=lambda index: (links[index].source, links[index].target))
    links = tuple(links[index] for index in order)
    if places is not None:
        places = Places(places.captured, tuple(places.steps[index] for index in order))
    graph = build_frame_graph(len(capture), capture.runs(), links)
    loop = largest_loop(graph)
    cyclic = loop is not None
    kept = np.ones(graph.nodes, bool) if loop is None else loop
    nodes, edges = _contract(graph, links, kept)
    frames = np.flatnonzero(kept[: graph.captured]).astype(np.int32)
    weights = target_weights(capture, options.visits)
    pulls = _pulls(weights[frames], frames, nodes, edges)
    traffic = Traffic.of_edges(len(nodes), [(e.source, e.target, len(e.inner_frames())) for e in edges], pulls)
    probabilities = even_probabilities(traffic)
    visits_even = visits = None
    obstacles: tuple[Obstacle, ...] = ()
    if cyclic:
        visits_even = _visits_per_frame(traffic, probabilities, frames, nodes, edges)
        probabilities = PROBABILITIES[options.probabilities](traffic, options)
        visits = _visits_per_frame(traffic, probabilities, frames, nodes, edges)
        obstacles = find_obstacles(graph, links, kept, weights)
    limits = thresholds(traffic.source, probabilities)
    return MotionGraph(
        frames, links, nodes, edges, probabilities, limits, cyclic, visits_even, visits, obstacles, places
    )


def _contract(graph: FrameGraph, links: Sequence[Link], kept: np.ndarray) -> tuple[np.ndarray, tuple[Edge, ...]]:
    """Nodes are the kept captured frames where ways meet, part, begin or end; edges are the ways between them."""
    inside = kept[graph.source] & kept[graph.target]
    # Captured edges come first in the frame graph and links follow in order: a stable sort keeps that order per node.
    order = np.flatnonzero(inside)[np.argsort(graph.source[inside], kind="stable")]
    source, target = graph.source[order], graph.target[order]
    ways_out = np.bincount(source, minlength=graph.nodes)
    ways_in = np.bincount(target, minlength=graph.nodes)
    is_node = kept & ((ways_out != 1) | (ways_in != 1))
    if not is_node.any() and kept.any():
        is_node[np.argmax(kept)] = True  # a bare ring: any one frame serves as its only node
    nodes = np.flatnonzero(is_node).astype(np.int32)
    position = {int(frame): index for index, frame in enumerate(nodes)}
    only_way = np.full(graph.nodes, -1)
    only_way[source] = target
    edges = []
    for start, after in zip(source, target, strict=True):
        if is_node[start]:
            played = [int(after)]
            while not is_node[played[-1]]:
                played.append(int(only_way[played[-1]]))
            segments = _segments(graph, links, played)
            transform = PlanarRigid()
            for segment in segments:
                if segment.link is not None:
                    transform = transform.after(links[segment.link].alignment)
            edges.append(Edge(position[int(start)], position[played[-1]], segments, transform))
    return nodes, tuple(edges)


def _segments(graph: FrameGraph, links: Sequence[Link], played: list[int]) -> tuple[Segment, ...]:
    segments: list[Segment] = []
    index = 0
    while index < len(played):
        node = played[index]
        if node >= graph.captured:
            link = int(np.searchsorted(graph.first_step, node, side="right")) - 1
            steps = links[link].steps
            segments.append(Segment(link, steps[0], steps[-1]))
            index += len(steps)
        else:
            last = index
            # A link's steps always stand between two captured frames that do not follow each other in the capture.
            while last + 1 < len(played) and played[last + 1] < graph.captured:
                last += 1
            segments.append(Segment(None, node, played[last]))
            index = last + 1
    return tuple(segments)


def _pulls(
    weights: np.ndarray, frames: np.ndarray, nodes: np.ndarray, edges: Sequence[Edge]
) -> tuple[np.ndarray, np.ndarray]:
    """1 / wanted share at every node, and added up inside every edge."""
    pull = weights.sum() / weights
    inside = [pull[np.searchsorted(frames, edge.inner_frames())].sum() for edge in edges]
    return pull[np.searchsorted(frames, nodes)], np.array(inside, np.float64)


def _visits_per_frame(
    traffic: Traffic, probabilities: np.ndarray, frames: np.ndarray, nodes: np.ndarray, edges: Sequence[Edge]
) -> np.ndarray:
    at_node, along_edge = traffic.visits(probabilities)
    visits = np.zeros(len(frames))
    visits[np.searchsorted(frames, nodes)] = at_node
    for edge, share in zip(edges, along_edge, strict=True):
        visits[np.searchsorted(frames, edge.inner_frames())] = share
    return visits
