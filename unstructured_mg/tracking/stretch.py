"""How much a tracked surface is stretched: what tells limbs that were taken for one another, and sliding."""

import numpy as np

from unstructured_mg.geometry.triangles import TriangleElements
from unstructured_mg.tracking.surface import face_normals


class Stretch:
    """Stretch of a surface (n, 3), (m, 3) in other poses; triangles without area do not count."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        self._elements = TriangleElements(vertices, faces)
        self._faces = faces

    def per_face(self, vertices: np.ndarray) -> np.ndarray:
        """(m,) max(s_1, 1 / s_2) >= 1 with the triangle's greatest and least stretch; infinite where it collapsed."""
        linear = self._elements.tangential(vertices)
        areas = self._elements.areas
        squares = np.einsum("fab,fab->f", linear, linear)
        ratio = np.divide(
            0.5 * np.linalg.norm(face_normals(vertices, self._faces), axis=1),
            areas,
            np.ones_like(areas),
            where=areas > 0,
        )
        # s_1^2 + s_2^2 is the squared norm of the map, s_1 s_2 the ratio of the areas.
        largest = np.sqrt(0.5 * (squares + np.sqrt(np.maximum(squares**2 - 4 * ratio**2, 0))))
        inverse_least = np.divide(largest, ratio, np.full_like(ratio, np.inf), where=ratio > 0)
        return np.where(areas > 0, np.maximum(largest, inverse_least), 1.0)

    def p95(self, vertices: np.ndarray) -> float:
        """The stretch that 95 % of the area do not exceed."""
        stretch, areas = self.per_face(vertices), self._elements.areas
        order = np.argsort(stretch, kind="stable")
        rank = np.searchsorted(np.cumsum(areas[order]), 0.95 * areas.sum()).clip(max=len(order) - 1)
        return float(stretch[order][rank])
