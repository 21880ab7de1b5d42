"""What a shape descriptor is to the rest of the room."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.matching.fields import Fields


@dataclass(frozen=True)
class Window:
    """All windows of one length.

    Attributes
    ----------
    k : frames either side of a window's centre
    weights : (2 k + 1,) float64, of a window's frames, summing to 1
    velocity : (n,) complex128: the root's velocity in the window about each frame, scaled so that the squared
        difference of two adds to their squared score
    """

    k: int
    weights: np.ndarray
    velocity: np.ndarray


@dataclass(frozen=True)
class Descriptor:
    """One kind of descriptor: what the frames are described by, and how windows of described frames compare.

    All functions are top-level ones, or partials of such, so that worker processes can be sent them.

    Attributes
    ----------
    unit : of the scores: "m", "rad", or "" for a pure number
    threshold : scores up to this are candidates, unless another is given: in metres for an actor of unit size where
        ``unit`` is "m", else in that unit
    resolution : the default of the option of that name, or None where the descriptor takes none
    colour : whether the descriptor can take colour in
    fit : (capture, (n, 5) extents, resolution, colour weight) -> a small picklable layout that all frames share; the
        resolution is None where there is none, the weight 0 where there is no colour
    shape : layout -> rows, cells and dtype of what describes one frame
    describe : (capture, index, (5,) extent, layout) -> that (rows, cells) array, and the frame's score against itself.
        A frame that cannot be described is a UserError
    compare : (fields, layout, own, rows, columns, windows) -> squared scores and yaws, both (len(rows), len(columns))
        float64, for each of the windows: those about the frames of ``rows`` against those about ``columns``. ``own``
        (n,) are the frames' scores against themselves. A yaw, in (-pi, pi], turns the column's window about +z onto
        the row's. Where ``columns`` is ``rows`` only the upper triangle counts. Centres without a whole window inside
        the capture count for nothing
    """

    unit: str
    threshold: float
    resolution: int | None
    colour: bool
    fit: Callable[[Capture, np.ndarray, int | None, float], Any]
    shape: Callable[[Any], tuple[int, int, type]]
    describe: Callable[[Capture, int, np.ndarray, Any], tuple[np.ndarray, float]]
    compare: Callable[[Fields, Any, np.ndarray, range, range, Sequence[Window]], list[tuple[np.ndarray, np.ndarray]]]
