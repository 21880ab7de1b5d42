"""Rigid motions of the floor plane: the transforms on a motion graph's edges (P section 7)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class PlanarRigid:
    """``p -> R(yaw) p + (x, y)`` in the floor plane, heights kept. ``yaw`` in radians about +z, ``x, y`` in metres."""

    yaw: float = 0.0
    x: float = 0.0
    y: float = 0.0

    @classmethod
    def from_matrix(cls, matrix: np.ndarray) -> "PlanarRigid":
        """From a (4, 4) matrix that is such a motion."""
        return cls(float(np.arctan2(matrix[1, 0], matrix[0, 0])), float(matrix[0, 3]), float(matrix[1, 3]))

    def matrix(self) -> np.ndarray:
        """(4, 4) float64, acting on column vectors."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return np.array([[c, -s, 0, self.x], [s, c, 0, self.y], [0, 0, 1, 0], [0, 0, 0, 1.0]])

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Move (..., 3) points."""
        matrix = self.matrix()
        return points @ matrix[:3, :3].T + matrix[:3, 3]

    def after(self, first: "PlanarRigid") -> "PlanarRigid":
        """The motion that does ``first``, then this."""
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return PlanarRigid(self.yaw + first.yaw, self.x + c * first.x - s * first.y, self.y + s * first.x + c * first.y)

    def inverse(self) -> "PlanarRigid":
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        return PlanarRigid(-self.yaw, -c * self.x - s * self.y, s * self.x - c * self.y)
