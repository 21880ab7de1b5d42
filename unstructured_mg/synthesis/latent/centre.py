"""Shapes on a common origin, as R section 3.1 wants them: what remains is posture."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.geometry.rotations import fit_planar

# The mean moves as the shapes turn towards it; a few rounds settle it.
ROUNDS = 3


@dataclass(frozen=True)
class Centred:
    """A shape whose centroid is the origin and that faces as the mean does, with the way back.

    Attributes
    ----------
    shape : (n, 3) float64, metres
    turn : radians about the vertical, by which the shape was turned
    centroid : (3,) float64, metres, where the shape stood
    """

    shape: np.ndarray
    turn: float
    centroid: np.ndarray

    def put_back(self, shape: np.ndarray) -> np.ndarray:
        """Take a centred ``shape`` (n, 3) to where this one stood."""
        return PlanarRigid(-self.turn, 0.0, 0.0).apply(shape) + self.centroid


def centre_on(vertices: np.ndarray, mean: np.ndarray) -> Centred:
    """Shift ``vertices`` (n, 3) to the origin and turn them about the vertical, nearest to ``mean`` (n, 3), centred."""
    centroid = vertices.mean(axis=0)
    shape = vertices - centroid
    turn = fit_planar(shape, mean, np.ones(len(shape))).yaw
    return Centred(PlanarRigid(turn, 0.0, 0.0).apply(shape), turn, centroid)


def centre_all(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centred shapes ``(f, n, 3)`` and their mean ``(n, 3)``, float64, of frames ``vertices`` (f, n, 3).

    Vertical turns are taken out as well as shifts: R's skeleton alignment does the same, and a walker who turns round
    would otherwise spend latent dimensions on it.
    """
    mean = vertices[0] - vertices[0].mean(axis=0)
    for _ in range(ROUNDS):
        shapes = np.stack([centre_on(frame, mean).shape for frame in vertices])
        mean = shapes.mean(axis=0)
    return shapes, mean
