"""A motion graph as JSON (docs/files.md, graph.json), complete: playback needs nothing else."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import Edge, MotionGraph, Segment
from unstructured_mg.graph.places import Places
from unstructured_mg.graph.uniformity import Obstacle

FORMAT_VERSION = 1
# Decimals of places: micrometres.
PLACE_DECIMALS = 6


def graph_to_json(
    graph: MotionGraph, capture: Capture, cards: Mapping[tuple[int, int], Mapping[str, Any]]
) -> dict[str, Any]:
    """JSON-ready, with frame ids in place of indices. ``cards`` holds the quality card of each (source, target)."""
    used = graph.links_used()
    name = capture.frame_id
    return {
        "format": "unstructured_mg graph",
        "version": FORMAT_VERSION,
        "capture_frames": len(capture),
        "fps": float(capture.fps),
        "cyclic": graph.cyclic,
        "frames": [name(int(frame)) for frame in graph.frames],
        "visits_even": None if graph.visits_even is None else graph.visits_even.tolist(),
        "visits": None if graph.visits is None else graph.visits.tolist(),
        "obstacles": [
            {
                "leads_to": o.leads_to,
                "crowd": [name(f) for f in o.crowd],
                "narrow": [name(f) for f in o.narrow],
                "excess": o.excess,
            }
            for o in graph.obstacles
        ],
        "places": None if graph.places is None else _points(graph.places.captured),
        "transitions": [
            {
                "source": name(link.source),
                "target": name(link.target),
                "k": link.k,
                "leaves": name(link.leaves),
                "arrives": name(link.arrives),
                "in_graph": index in used,
                "cost": float(link.cost),
                "alignment": {**_motion(link.alignment), "matrix": link.alignment.matrix().tolist()},
                "places": None if graph.places is None else _points(graph.places.steps[index]),
                "quality": dict(cards.get((link.source, link.target), {})),
            }
            for index, link in enumerate(graph.links)
        ],
        "nodes": [name(int(frame)) for frame in graph.nodes],
        "edges": [
            {
                "source": edge.source,
                "target": edge.target,
                "plays": [_segment(segment, capture) for segment in edge.segments],
                "length": len(edge),
                "probability": float(graph.probabilities[index]),
                "threshold": int(graph.thresholds[index]),
                "transform": _motion(edge.transform),
            }
            for index, edge in enumerate(graph.edges)
        ],
    }


def graph_from_json(data: Mapping[str, Any], capture: Capture) -> MotionGraph:
    """The graph that ``graph_to_json`` wrote, for the same capture.

    Raises
    ------
    UserError
        Where it is of another kind or of a version that this program does not know.
    """
    if data.get("format") != "unstructured_mg graph" or data.get("version") != FORMAT_VERSION:
        raise UserError(
            f"graph.json: format {data.get('format')!r}, version {data.get('version')!r} is not the expected "
            f"'unstructured_mg graph', version {FORMAT_VERSION}: build the graph again with this program."
        )
    index = capture.index_of
    links = tuple(_read_link(transition, capture) for transition in data["transitions"])
    edges = tuple(
        Edge(
            e["source"],
            e["target"],
            tuple(_read_segment(played, links, capture) for played in e["plays"]),
            _planar(e["transform"]),
        )
        for e in data["edges"]
    )
    places = None
    if data.get("places") is not None:
        steps = tuple(np.array(t["places"], np.float64).reshape(-1, 2) for t in data["transitions"])
        places = Places(np.array(data["places"], np.float64).reshape(-1, 2), steps)
    visits_even, visits = (None if data[key] is None else np.array(data[key]) for key in ("visits_even", "visits"))
    return MotionGraph(
        frames=np.array([index(frame) for frame in data["frames"]], np.int32),
        links=links,
        nodes=np.array([index(frame) for frame in data["nodes"]], np.int32),
        edges=edges,
        probabilities=np.array([e["probability"] for e in data["edges"]], np.float64),
        thresholds=np.array([e["threshold"] for e in data["edges"]], np.uint32),
        cyclic=data["cyclic"],
        visits_even=visits_even,
        visits=visits,
        obstacles=tuple(
            Obstacle(o["leads_to"], tuple(map(index, o["crowd"])), tuple(map(index, o["narrow"])), o["excess"])
            for o in data["obstacles"]
        ),
        places=places,
    )


def _read_link(entry: Mapping[str, Any], capture: Capture) -> Link:
    source, target, leaves, arrives = (
        capture.index_of(entry[name]) for name in ("source", "target", "leaves", "arrives")
    )
    straight = (leaves, arrives) == (source - entry["k"], target + entry["k"])
    ends = None if straight else (leaves, arrives)
    return Link(source, target, entry["k"], _planar(entry["alignment"]), entry["cost"], ends)


def _segment(segment: Segment, capture: Capture) -> dict[str, Any]:
    if segment.link is not None:
        return {"transition": segment.link}
    return {"first": capture.frame_id(segment.first), "last": capture.frame_id(segment.last)}


def _read_segment(played: Mapping[str, Any], links: tuple[Link, ...], capture: Capture) -> Segment:
    if "transition" in played:
        steps = links[played["transition"]].steps
        return Segment(played["transition"], steps[0], steps[-1])
    return Segment(None, capture.index_of(played["first"]), capture.index_of(played["last"]))


def _points(points: np.ndarray) -> list[list[float]]:
    return [[round(float(x), PLACE_DECIMALS), round(float(y), PLACE_DECIMALS)] for x, y in points]


def _motion(motion: PlanarRigid) -> dict[str, float]:
    return {"yaw": float(motion.yaw), "x": float(motion.x), "y": float(motion.y)}


def _planar(motion: Mapping[str, float]) -> PlanarRigid:
    return PlanarRigid(motion["yaw"], motion["x"], motion["y"])
