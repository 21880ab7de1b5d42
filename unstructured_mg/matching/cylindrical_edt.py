"""The descriptor of P A.1: a surface's area and squared distance transform on one cylinder for the whole capture."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg import _native
from unstructured_mg.capture.capture import Capture
from unstructured_mg.matching import correlation
from unstructured_mg.matching.descriptor import Descriptor
from unstructured_mg.matching.face_colours import face_colours

# No frame makes the cylinder wider or higher than this many times the median frame: a broken one must not coarsen the
# rest.
WIDEST = 4.0


@dataclass(frozen=True)
class Cylinder:
    """Grid of ``radii`` x ``heights`` x ``angles`` points about a vertical axis through a frame's centre of mass.

    Point (j, i, a) lies at radius ``(j + 1/2) radius_step``, height ``bottom + i height_step`` (metres above the
    floor: heights are not centred, a jump does not match a stand) and angle ``2 pi a / angles``. ``colour``: metres
    that the largest difference of a colour channel counts for, 0 where colours do not count.
    """

    radii: int
    heights: int
    angles: int
    radius_step: float
    bottom: float
    height_step: float
    colour: float = 0.0


def fit(capture: Capture, extents: np.ndarray, resolution: int | None, colour: float = 0.0) -> Cylinder:
    """The cylinder around all frames, from their ``extents`` (n, 5), with a margin for the cubic stencil."""
    assert resolution is not None
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
        colour,
    )


def shape(cylinder: Cylinder) -> tuple[int, int, type]:
    """Rows (frequencies of both fields) and cells, complex64; colour adds three quarters of a field."""
    cells = cylinder.radii * cylinder.heights
    return cylinder.angles, cells + (3 * cells // 4 if cylinder.colour else 0), np.complex64


def describe(capture: Capture, index: int, extent: np.ndarray, cylinder: Cylinder) -> tuple[np.ndarray, float]:
    """Fourier coefficients over the angle of the area measure X and of the squared distance E, packed; and D_ii(0).

    X holds the frame's area, scaled to a total of 1, spread from dense samples by cubic convolution, so that <X, E>
    is the mean over the surface of E interpolated by cubics. These reproduce quadratics, and a squared distance is
    one near a smooth surface: a frame's score against itself is about (2 mm)^2, not the (1 cm)^2 of trilinear
    spreading, and does not hide the motion between neighbouring frames. X is a measure and not a density: the paper's
    factor m (radius) is in it.

    With colour, E gains lambda^2 |C_t - c_s|^2, c_s the colours of surface s and C_t those of the nearest points of
    surface t, so that a score is a distance in space and colour: the square of C_t joins E, the products are three
    more fields, of cells of 2 x 2 radii and heights, and the square of c_s falls out with the frame's own score.
    """
    mesh = capture.read(index)
    left, right, nearest = sample(mesh.vertices - [extent[0], extent[1], 0.0], mesh.faces, cylinder)
    cells = (cylinder.radii * cylinder.heights, cylinder.angles)
    lefts, rights = [left.reshape(cells)], [right.reshape(cells)]
    if cylinder.colour:
        colours = cylinder.colour * face_colours(mesh)[nearest]
        rights[0] = (right + (colours**2).sum(axis=3)).reshape(cells)
        for channel in np.moveaxis(colours, 3, 0):
            lefts.append(_pooled(left * channel, cylinder))
            rights.append(_pooled(channel, cylinder) * np.float32(-2 / 4))
    left, right = np.concatenate(lefts), np.concatenate(rights)
    own = float(np.einsum("ca,ca->", left, right, dtype=np.float64))
    return correlation.pack(left, right), own


def sample(vertices: np.ndarray, faces: np.ndarray, cylinder: Cylinder) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Area measure (total 1), squared distance in m^2, both float32, and nearest face, int32: (radii, heights, angles).

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
    indicator, square, nearest = np.empty(shape, np.float32), np.empty(shape, np.float32), np.empty(shape, np.int32)
    steps = (cylinder.radius_step, cylinder.bottom, cylinder.height_step)
    part, rounds = min(cylinder.radius_step, cylinder.height_step), 2
    _native.cylindrical_edt(vertices, faces, indicator, square, nearest, *shape, *steps, part, rounds)
    indicator /= indicator.sum(dtype=np.float64)
    return indicator, square, nearest


def _pooled(field: np.ndarray, cylinder: Cylinder) -> np.ndarray:
    """Sums over 2 x 2 radii and heights of a field (radii, heights, angles): (cells / 4, angles)."""
    split = field.reshape(cylinder.radii // 2, 2, cylinder.heights // 2, 2, cylinder.angles)
    return split.sum(axis=(1, 3)).reshape(-1, cylinder.angles)


DESCRIPTOR = Descriptor("m", 0.04, 64, True, fit, shape, describe, correlation.compare)
