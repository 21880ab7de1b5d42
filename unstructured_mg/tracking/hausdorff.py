"""How far a tracked surface and the captured one are apart, both ways."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.geometry.nearest import NearestPoints
from unstructured_mg.tracking.target import Target


@dataclass(frozen=True)
class SurfaceDistance:
    """Metres, over the vertices of both surfaces: ``largest`` (two-sided Hausdorff), and by area ``mean``, ``p95``."""

    largest: float
    mean: float
    p95: float


def surface_distance(
    vertices: np.ndarray, faces: np.ndarray, areas: np.ndarray, target: Target, order: np.ndarray | None = None
) -> SurfaceDistance:
    """Between a surface (n, 3), (m, 3) with vertex areas (n,) and a target, both already without debris.

    ``order`` (m,), where given, sorts the faces as ``NearestPoints`` wants them.
    """
    there = target.distances(vertices)
    back = np.sqrt(NearestPoints(vertices, faces, order).query(target.vertices)[0])
    used, seen = areas > 0, target.areas > 0
    distance = np.concatenate([there[used], back[seen]])
    weight = np.concatenate([areas[used] / areas.sum(), target.areas[seen] / target.areas.sum()]) / 2
    order = np.argsort(distance, kind="stable")
    ninety_five = distance[order][np.searchsorted(np.cumsum(weight[order]), 0.95, side="left").clip(max=len(order) - 1)]
    return SurfaceDistance(float(distance.max()), float((weight * distance).sum()), float(ninety_five))
