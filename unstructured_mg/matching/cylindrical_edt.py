"""The descriptor of P A.1: a surface's area and squared distance transform on one cylinder for the whole capture."""

from dataclasses import dataclass

import numpy as np
import scipy.fft

from unstructured_mg import _native
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.laplacian import face_areas

# This share of a frame's area may lie outside the cylinder at each end (stray triangles); it counts as lying on its
# border.
OUTSIDE = 2e-3
# No frame makes the cylinder wider or higher than this many times the median frame: a broken one must not coarsen the
# rest.
WIDEST = 4.0


@dataclass(frozen=True)
class Cylinder:
    """Grid of ``radii`` x ``heights`` x ``angles`` points about a vertical axis through a frame's centre of mass.

    Point (j, i, a) lies at radius ``(j + 1/2) radius_step``, height ``bottom + i height_step`` (metres above the
    floor: heights are not centred, a jump does not match a stand) and angle ``2 pi a / angles``.
    """

    radii: int
    heights: int
    angles: int
    radius_step: float
    bottom: float
    height_step: float


def shape(resolution: int) -> tuple[int, int, int]:
    """Frequencies, cells (radius by height) and angles. The frequency ``angles / 2`` carries no direction: left out."""
    return resolution, resolution // 2 * resolution, 2 * resolution


def extent(mesh: TexturedMesh) -> np.ndarray:
    """``(5,) float64``: the centre of mass x, y; but for outlying area, radius about it, least and most height."""
    corner_mass = np.repeat(face_areas(mesh.vertices, mesh.faces) / 3, 3)
    mass = np.bincount(mesh.faces.ravel(), corner_mass, minlength=len(mesh.vertices))
    if not mass.sum() > 0:
        raise ValueError("mesh: expected a surface with an area, got none")
    # Not a BLAS product, which rounds otherwise with another number of threads.
    axis = (mass[:, None] * mesh.vertices[:, :2]).sum(axis=0) / mass.sum()
    radius = np.hypot(mesh.vertices[:, 0] - axis[0], mesh.vertices[:, 1] - axis[1])
    height = mesh.vertices[:, 2]
    return np.array(
        [
            *axis,
            _quantile(radius, mass, 1 - OUTSIDE),
            _quantile(height, mass, OUTSIDE),
            _quantile(height, mass, 1 - OUTSIDE),
        ]
    )


def fit(extents: np.ndarray, resolution: int) -> Cylinder:
    """The cylinder around all frames, from their ``extents`` (n, 5), with a margin for the cubic stencil."""
    radius = min(extents[:, 2].max(), WIDEST * np.median(extents[:, 2]))
    middle = np.median(extents[:, 3:].mean(axis=1))
    half = WIDEST * np.median(extents[:, 4] - extents[:, 3]) / 2
    low, high = max(extents[:, 3].min(), middle - half), min(extents[:, 4].max(), middle + half)
    size = max(radius, high - low)
    radius, height = max(radius, 1e-3 * size), max(high - low, 1e-3 * size)
    radii, heights = resolution // 2, resolution
    height_step = height / (heights - 4)
    return Cylinder(
        radii,
        heights,
        2 * resolution,
        float(radius / (radii - 2.5)),
        float(low - 1.5 * height_step),
        float(height_step),
    )


def describe(mesh: TexturedMesh, extent: np.ndarray, cylinder: Cylinder) -> tuple[np.ndarray, np.ndarray, float]:
    """Fourier coefficients over the angle of the area measure X and, conjugated, of the squared distance E.

    X holds the frame's area, scaled to a total of 1, spread from dense samples by cubic convolution, so that <X, E>
    is the mean over the surface of E interpolated by cubics. These reproduce quadratics, and a squared distance is
    one near a smooth surface: a frame's score against itself is about (2 mm)^2, not the (1 cm)^2 of trilinear
    spreading, and does not hide the motion between neighbouring frames. X is a measure and not a density: the paper's
    factor m (radius) is in it.

    Returns (angles / 2, radii * heights) complex64 twice and D_ii(0) = <X, E> in square metres. The one frequency
    left out, angles / 2, carries no direction.
    """
    indicator, square = sample(mesh.vertices - [extent[0], extent[1], 0.0], mesh.faces, cylinder)
    own = float(np.einsum("jia,jia->", indicator, square, dtype=np.float64))
    keep = cylinder.angles // 2
    left, right = (
        scipy.fft.rfft(field.reshape(-1, cylinder.angles), axis=1)[:, :keep].T for field in (indicator, square)
    )
    return left, right.conj(), own


def sample(vertices: np.ndarray, faces: np.ndarray, cylinder: Cylinder) -> tuple[np.ndarray, np.ndarray]:
    """Area measure (total 1) and squared distance in m^2, both ``(radii, heights, angles) float32``.

    Triangles are cut into parts of at most one grid step. A distance is that to the part found nearest (within three
    steps, to its triangle) by two rounds of handing parts on along the three grid directions: never too small; too
    large, on people at a grid step of 30 mm, by 0.2 mm on average and 9 mm at most within three steps, where the scores
    that matter are made, and by 1 mm and 17 mm farther away.
    """
    vertices, faces = np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(faces, np.int32)
    if not np.isfinite(vertices).all():
        raise ValueError("vertices: expected finite coordinates, got NaN or infinity")
    if len(faces) == 0 or faces.min() < 0 or faces.max() >= len(vertices):
        raise ValueError(f"faces: expected at least one, with indices in 0..{len(vertices) - 1}")
    shape = (cylinder.radii, cylinder.heights, cylinder.angles)
    indicator, square = np.empty(shape, np.float32), np.empty(shape, np.float32)
    steps = (cylinder.radius_step, cylinder.bottom, cylinder.height_step)
    part, rounds = min(cylinder.radius_step, cylinder.height_step), 2
    _native.cylindrical_edt(vertices, faces, indicator, square, *shape, *steps, part, rounds)
    indicator /= indicator.sum(dtype=np.float64)
    return indicator, square


def _quantile(values: np.ndarray, weights: np.ndarray, share: float) -> float:
    """Value below which ``share`` of the weight lies, to 1 / 4096 of the range: a sort takes ten times as long."""
    low, high = values.min(), values.max()
    step = (high - low) / 4096 or 1.0
    cells = np.minimum((values - low) / step, 4095).astype(np.intp)
    total = np.cumsum(np.bincount(cells, weights, 4096))
    return float(low + step * (np.searchsorted(total, share * total[-1]) + 1))
