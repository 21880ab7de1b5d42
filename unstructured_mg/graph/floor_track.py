"""The way over the floor of frames that are played one after the other."""

from collections.abc import Iterable

import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import Segment
from unstructured_mg.graph.places import Places


def floor_track(places: Places, links: tuple[Link, ...], segments: Iterable[Segment]) -> tuple[np.ndarray, PlanarRigid]:
    """Centres of the played frames and where they lead.

    Returns
    -------
    points : (frames, 2) float64, metres, in the captured place of the frame that is shown before ``segments``
    motion : from the last frame's captured place to that one
    """
    parts, world = [np.zeros((0, 2))], PlanarRigid()
    for segment in segments:
        if segment.link is None:
            parts.append(moved(places.captured[segment.first : segment.last + 1], world))
        else:
            link = links[segment.link]
            first = segment.first - link.steps[0]
            parts.append(moved(places.steps[segment.link][first : first + len(segment)], world))
            world = world.after(link.alignment)
    return np.concatenate(parts), world


def track_length(points: np.ndarray) -> float:
    """Metres of the polygon through ``points`` (m, 2): H eq. 8's distance."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def moved(points: np.ndarray, motion: PlanarRigid) -> np.ndarray:
    """(..., 2) points of the floor, moved."""
    matrix = motion.matrix()
    return np.asarray(points @ matrix[:2, :2].T + matrix[:2, 3])
