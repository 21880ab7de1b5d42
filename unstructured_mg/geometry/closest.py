"""Closest points on a triangle mesh; the tree is built once and kept."""

import igl
import numpy as np


class ClosestPoints:
    """Closest-point queries on one mesh: vertices (n, 3) float64, faces (m, 3) int32 with indices in range.

    Raises ValueError for an empty mesh or an index out of range (libigl would crash the process).
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        self.vertices = np.ascontiguousarray(vertices, dtype=np.float64)
        self.faces = np.ascontiguousarray(faces, dtype=np.int32)
        if self.faces.ndim != 2 or self.faces.shape[1:] != (3,) or len(self.faces) == 0:
            raise ValueError(f"faces: expected (m, 3) with m > 0, got {self.faces.shape}")
        if self.faces.min() < 0 or self.faces.max() >= len(self.vertices):
            raise ValueError(f"faces: expected indices in 0..{len(self.vertices) - 1}")
        if not np.isfinite(self.vertices).all():
            raise ValueError("vertices: expected finite coordinates, got NaN or infinity")
        self._tree = igl.AABB()
        self._tree.init(self.vertices, self.faces)

    def query(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """For points (p, 3): squared distances (p,), face indices (p,) int64, closest points (p, 3)."""
        points = np.ascontiguousarray(points, dtype=np.float64)
        squared, face, closest = self._tree.squared_distance(self.vertices, self.faces, points)
        return np.ravel(squared), np.ravel(face).astype(np.int64), closest

    def barycentric(self, face: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Barycentric weights (p, 3) of points that lie on the given faces; thirds on zero-area faces."""
        a, b, c = (self.vertices[self.faces[face, i]] for i in range(3))
        u, v, w = b - a, c - a, points - a
        uu, uv, vv = (np.einsum("ij,ij->i", x, y) for x, y in ((u, u), (u, v), (v, v)))
        wu, wv = np.einsum("ij,ij->i", w, u), np.einsum("ij,ij->i", w, v)
        determinant = uu * vv - uv * uv
        usable = determinant > 1e-14 * np.maximum(uu * vv, 1e-300)
        safe = np.where(usable, determinant, 1.0)
        second, third = (vv * wu - uv * wv) / safe, (uu * wv - uv * wu) / safe
        weights = np.stack([1 - second - third, second, third], axis=1)
        return np.where(usable[:, None], weights, 1.0 / 3.0)
