"""Nearest points on a mesh for many points again and again: a tree that is cheap to build and takes guesses."""

import numpy as np

from unstructured_mg import _native
from unstructured_mg.geometry.morton import morton_order

_WIDE = 8


class NearestPoints:
    """Nearest-point queries on one mesh: vertices (n, 3) float64, faces (m, 3) int32 with indices in range.

    For meshes that live for a few queries of thousands of points; ``ClosestPoints`` answers the same. ``order`` (m,),
    where given, sorts the faces so that neighbours in space follow each other: the ``order`` of an earlier tree serves
    for the same faces in another pose. Raises ValueError for an empty mesh, an index out of range or a coordinate that
    is not finite.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray, order: np.ndarray | None = None):
        vertices = np.asarray(vertices, dtype=np.float64)
        if faces.ndim != 2 or faces.shape[1:] != (3,) or len(faces) == 0:
            raise ValueError(f"faces: expected (m, 3) with m > 0, got {faces.shape}")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise ValueError(f"faces: expected indices in 0..{len(vertices) - 1}, got {faces.min()}..{faces.max()}")
        if not np.isfinite(vertices).all():
            raise ValueError("vertices: expected finite coordinates, got NaN or infinity")
        if order is None:
            order = morton_order(vertices[faces[:, 0]] + vertices[faces[:, 1]] + vertices[faces[:, 2]])
        self.order = order
        a, b, c = (vertices[corner] for corner in faces[order].T)
        self._corners = np.ascontiguousarray(np.concatenate([a, b - a, c - a], axis=1))
        low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        levels: list[np.ndarray] = []
        while not levels or len(low) > 1:
            padding = np.full((-len(low) % _WIDE, 3), np.inf)
            # A box that is not there is infinitely far away.
            lows = np.concatenate([low, padding]).reshape(-1, _WIDE, 3)
            highs = np.concatenate([high, -padding]).reshape(-1, _WIDE, 3)
            levels.append(np.concatenate([lows.transpose(0, 2, 1), highs.transpose(0, 2, 1)], axis=1))
            starts = np.arange(0, len(low), _WIDE)
            low, high = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
        self._boxes = np.ascontiguousarray(np.concatenate(levels[::-1]))

    def query(
        self, points: np.ndarray, slots: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """For points (p, 3): squared distances (p,), faces (p,), barycentric weights (p, 3) and slots (p,) int32.

        ``slots`` are what an earlier query of this tree gave for points near these: the search is shorter for it, the
        distances are the same.
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ValueError(f"points: expected (p, 3), got {points.shape}")
        if slots is not None and (slots.shape != (len(points),) or slots.dtype != np.int32):
            raise ValueError(f"slots: expected ({len(points)},) int32, got {slots.shape} {slots.dtype}")
        if slots is not None:
            return self._search(points, slots.copy())
        if len(points) == 0:
            return self._search(points, np.empty(0, np.int32))
        # Without guesses each answer is the next one's: points are taken in an order in which that is a good one.
        order = morton_order(points)
        answers = self._search(points[order], np.full(len(points), -1, np.int32))
        back = np.empty_like(order)
        back[order] = np.arange(len(order))
        squared, face, weights, found = (answer[back] for answer in answers)
        return squared, face, weights, found

    def _search(self, points: np.ndarray, slots: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        weights, squared = np.empty((len(points), 3)), np.empty(len(points))
        _native.nearest_on_triangles(
            len(self._corners), len(points), self._boxes, self._corners, points, slots, weights, squared
        )
        return squared, self.order[slots], weights, slots
