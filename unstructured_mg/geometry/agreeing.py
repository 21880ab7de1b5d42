"""Closest points among the faces that look the same way: never the other side of a thin part."""

import numpy as np

from unstructured_mg import _native
from unstructured_mg.geometry.morton import morton_order
from unstructured_mg.geometry.normals import face_normals

LEAF_SIZE = 2


class AgreeingPoints:
    """Closest-point queries that only accept faces whose normal agrees with the query's.

    vertices (n, 3) float64, faces (m, 3) int32 with indices in range. Faces without area are never found.
    Raises ValueError for an empty mesh, an index out of range or a coordinate that is not finite.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        vertices = np.asarray(vertices, dtype=np.float64)
        faces = np.asarray(faces, dtype=np.int32)
        if faces.ndim != 2 or faces.shape[1:] != (3,) or len(faces) == 0:
            raise ValueError(f"faces: expected (m, 3) with m > 0, got {faces.shape}")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise ValueError(f"faces: expected indices in 0..{len(vertices) - 1}")
        if not np.isfinite(vertices).all():
            raise ValueError("vertices: expected finite coordinates, got NaN or infinity")
        corners = vertices[faces]
        self._order = morton_order(corners.mean(axis=1))
        blocks = -(-len(faces) // LEAF_SIZE)
        self._leaves = 1 << max(blocks - 1, 0).bit_length()
        slots = self._leaves * LEAF_SIZE
        self._corners = np.zeros((slots, 3, 3))
        self._corners[: len(faces)] = corners[self._order]
        self._normals = np.zeros((slots, 3))
        self._normals[: len(faces)] = face_normals(vertices, faces)[self._order]
        low, high = np.full((slots, 3), np.inf), np.full((slots, 3), -np.inf)
        low[: len(faces)] = self._corners[: len(faces)].min(axis=1)
        high[: len(faces)] = self._corners[: len(faces)].max(axis=1)
        level = np.concatenate(
            [low.reshape(-1, LEAF_SIZE, 3).min(axis=1), high.reshape(-1, LEAF_SIZE, 3).max(axis=1)], axis=1
        )
        levels = [level]
        while len(level) > 1:
            pairs = level.reshape(-1, 2, 6)
            level = np.concatenate([pairs[:, :, :3].min(axis=1), pairs[:, :, 3:].max(axis=1)], axis=1)
            levels.append(level)
        self._boxes = np.ascontiguousarray(np.concatenate(levels[::-1]))

    def query(
        self, points: np.ndarray, normals: np.ndarray, limit: float, agreement: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For points and unit normals (p, 3): face indices (p,) int64, barycentric weights (p, 3), distances (p,).

        Only faces nearer than ``limit`` (metres) whose unit normal's dot product with the point's is at least
        ``agreement`` count; where there is none the face is -1 and the distance infinite. Fast where points that
        follow each other are near each other.
        """
        points = np.ascontiguousarray(points, dtype=np.float64)
        normals = np.ascontiguousarray(normals, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or normals.shape != points.shape:
            raise ValueError(f"points, normals: expected equal shapes (p, 3), got {points.shape} and {normals.shape}")
        count = len(points)
        slots, weights, squared = np.empty(count, np.int32), np.empty((count, 3)), np.empty(count)
        # A face without normal (zeros) agrees with nothing only where the threshold is above zero.
        agreement = max(agreement, 1e-9)
        _native.closest_agreeing(
            self._leaves, LEAF_SIZE, self._boxes, self._corners, self._normals, count, points, normals,
            limit, agreement, slots, weights, squared,
        )  # fmt: skip
        face = np.where(slots >= 0, self._order[np.maximum(slots, 0)], -1)
        return face, weights, np.sqrt(squared)
