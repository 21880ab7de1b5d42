"""From metres, z up, back to an export's axis and unit."""

from dataclasses import dataclass, replace

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.placement import UP_AXES
from unstructured_mg.geometry.planar import PlanarRigid


@dataclass(frozen=True)
class ExportSpace:
    """The coordinates that an export is written in.

    Attributes
    ----------
    up : its up axis, as in Capture
    unit : metres per unit
    floor : the floor's height along the up axis, in units
    from_metres : (4, 4) float64 similarity on column vectors, from metres, z up, floor 0
    """

    up: str
    unit: float
    floor: float
    from_metres: np.ndarray

    def points(self, vertices: np.ndarray) -> np.ndarray:
        """Bring (n, 3) vertices from metres, z up."""
        return vertices @ self.from_metres[:3, :3].T + self.from_metres[:3, 3]

    def world(self, motion: PlanarRigid) -> np.ndarray:
        """``motion`` as the (4, 4) matrix that takes a frame's own place to the world, both in this space.

        Where the floor lies elsewhere than at 0, or the up axis is another, this is not the same matrix as in metres.
        """
        matrix = self.from_metres @ motion.matrix() @ np.linalg.inv(self.from_metres)
        # The products leave crumbs of 1e-16 in what is exactly 0 or 1; adding 0 turns -0 into 0.
        return np.round(matrix, 12) + 0.0


def export_space(capture: Capture, up: str | None = None, unit: float | None = None) -> ExportSpace:
    """The capture's own axis and unit, unless others are asked for; the floor stays at the capture's height.

    Raises
    ------
    ValueError
        Where ``up`` is no axis or ``unit`` is not a positive number of metres.
    """
    up = capture.up if up is None else up
    unit = capture.unit if unit is None else unit
    if up not in UP_AXES:
        raise ValueError(f"up: expected one of {', '.join(UP_AXES)}, got {up!r}")
    if not 0 < unit < float("inf"):
        raise ValueError(f"unit: expected a positive number of metres, got {unit!r}")
    asked = replace(capture, up=up, unit=unit, floor=capture.floor * capture.unit / unit)
    return ExportSpace(up, unit, asked.floor, np.linalg.inv(asked.to_metres()))
