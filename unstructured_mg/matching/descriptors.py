"""The shape descriptors by name.

A descriptor gives every frame two fields of Fourier coefficients over the yaw, ``left`` X and ``right`` E, such that
two frames s, t, the latter turned by yaw, differ by the bilinear form

    D_st(yaw) = 1/2 (<X_s, R(yaw) E_t> + <E_s, R(yaw) X_t>),   d_st = D_st - (D_ss(0) + D_tt(0)) / 2.

That covers a surface measure against squared distances (P A.1) and, with E = -X, |X_s - X_t|^2 / 2. Everything after
the fields (windows, yaw, candidates) is common to all descriptors.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.matching import cylindrical_edt


@dataclass(frozen=True)
class Descriptor:
    """One kind of descriptor: three top-level functions, so that worker processes can be sent them.

    Attributes
    ----------
    extent : mesh -> (e,) float64: what ``fit`` needs to know of one frame; the first two are x and y of the root, the
        point on the floor whose path is the actor's way through the room, the third to fifth radius, lowest and
        highest point
    fit : ((n, e) extents, resolution) -> a small picklable layout shared by all frames
    describe : (mesh, (e,) extent, layout) -> left, right, both (frequencies, cells) complex64 (frequencies 0, 1, ...
        of an FFT over the yaws), and D_ii(0)
    shape : resolution -> frequencies, cells, and the number of yaws on the circle (even)
    """

    extent: Callable[[TexturedMesh], np.ndarray]
    fit: Callable[[np.ndarray, int], Any]
    describe: Callable[[TexturedMesh, np.ndarray, Any], tuple[np.ndarray, np.ndarray, float]]
    shape: Callable[[int], tuple[int, int, int]]


DESCRIPTORS: dict[str, Descriptor] = {
    "cylindrical_edt": Descriptor(
        cylindrical_edt.extent, cylindrical_edt.fit, cylindrical_edt.describe, cylindrical_edt.shape
    ),
}
