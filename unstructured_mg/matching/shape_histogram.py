"""The descriptor of H section 3.1: how a body's volume is spread over spherical cells."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.matching import correlation
from unstructured_mg.matching.descriptor import Descriptor

# Bins of the radius, of the angle from the vertical and of the angle about it (H section 3.1).
RADII, TILTS, TURNS = 10, 20, 40
# Samples of the circle before they are taken together into bins; H has 360.
FINE = 1024
# Faces are cut into parts of at most this share of the largest radius.
PART = 1 / 64
# What a surface must enclose, as a share of its area to the power 1.5: a ball has 0.094, a standing body about 0.03.
LEAST_VOLUME = 1e-3


@dataclass(frozen=True)
class Cells:
    """RADII shells up to ``radius`` (metres) about a point above a frame's centre of mass, at ``height`` for all
    frames: heights are not centred, a jump does not match a stand. ``angles``: yaws that are told apart.
    """

    radius: float
    height: float
    angles: int


def fit(capture: Capture, extents: np.ndarray, resolution: int | None, colour: float = 0.0) -> Cells:
    """Shells that hold all frames, from their ``extents`` (n, 5)."""
    assert resolution is not None
    height = float(np.median(extents[:, 3:].mean(axis=1)))
    reach = np.maximum(extents[:, 4] - height, height - extents[:, 3])
    return Cells(float(np.hypot(extents[:, 2], reach).max()), height, 2 * resolution)


def shape(cells: Cells) -> tuple[int, int, type]:
    return cells.angles, RADII * TILTS, np.complex64


def describe(capture: Capture, index: int, extent: np.ndarray, cells: Cells) -> tuple[np.ndarray, float]:
    """Fourier coefficients over the yaw of the histogram, packed so that scores are H's equation 2.

    H cuts a fine histogram into TURNS bins, after shifting it by whole degrees, and takes the Euclidean distance. How
    the bins happen to lie makes a difference there, and s(i, j) is not quite s(j, i). Here the square is averaged over
    all ways the bins can lie, which is to slide one bin around the circle: it then depends on the difference of the
    yaws only. ``angles / 2`` frequencies are kept; a bin of 9 degrees leaves next to nothing beyond 64.
    """
    mesh = capture.read(index)
    centre = [extent[0], extent[1], cells.height]
    spectrum = np.fft.rfft(volume_histogram(mesh.vertices - centre, mesh.faces, cells.radius), axis=2)
    keep = cells.angles // 2
    if not np.isfinite(spectrum).all():
        raise UserError(
            f"{capture.frames[index].path}: encloses no volume, so it has no shape histogram; "
            "choose another descriptor (--descriptor cylindrical_edt)."
        )
    bins = spectrum[:, :, :keep] * np.sinc(np.arange(keep) / TURNS) / TURNS
    # As samples of the sliding bin's content at `angles` yaws, scaled so that their squares add to a mean times TURNS.
    coefficients = (bins * np.sqrt(TURNS * cells.angles)).reshape(-1, keep).T.astype(np.complex64)
    energy = np.abs(coefficients.astype(np.complex128)) ** 2
    own = -2 * float(energy[0].sum() + 2 * energy[1:].sum()) / cells.angles
    return np.concatenate([coefficients, -2 * coefficients.conj()]), own


def volume_histogram(vertices: np.ndarray, faces: np.ndarray, radius: float) -> np.ndarray:
    """``(RADII, TILTS, FINE) float64``, total 1: the volume inside a closed surface by radius about the origin, angle
    from the vertical, and angle about it. NaN where it encloses none. Farther than ``radius`` counts as there.

    H counts voxels inside the surface. This is the same without voxels: a ray from the origin is inside from nought to
    every place where it leaves the surface, less from nought to every place where it enters. A small piece of surface
    at p, of area vector dA, is met by rays of the solid angle p.dA / |p|^3, positive where they leave, and stands for
    the volume of that cone up to |p|. Surfaces with holes are as if closed towards the origin; those with every
    triangle on both sides enclose nothing.
    """
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    longest = np.sqrt(np.max([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)], axis=0))
    parts = np.clip(np.ceil(longest / (PART * radius)), 1, 64).astype(int)
    area_vectors = np.cross(b - a, c - a) / 2
    points, vectors = [], []
    for count in np.unique(parts):
        chosen = parts == count
        u, v = _barycentres(int(count))
        corner, along, across = a[chosen, None], (b - a)[chosen, None], (c - a)[chosen, None]
        points.append((corner + u[:, None] * along + v[:, None] * across).reshape(-1, 3))
        vectors.append(np.repeat(area_vectors[chosen] / count**2, len(u), axis=0))
    p, vector = np.concatenate(points), np.concatenate(vectors)
    distance = np.linalg.norm(p, axis=1)
    cone = np.einsum("pi,pi->p", p, vector) / np.maximum(distance, 1e-9 * radius) ** 3
    tilt = np.arccos(np.clip(p[:, 2] / np.maximum(distance, 1e-9 * radius), -1, 1))
    turn = np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi)
    shell = np.minimum((distance / radius * RADII).astype(int), RADII - 1)
    column = np.minimum((tilt / np.pi * TILTS).astype(int), TILTS - 1) * FINE + np.floor(turn * FINE).astype(int) % FINE
    edges = radius * np.arange(RADII + 1) / RADII
    shells = (edges[1:] ** 3 - edges[:-1] ** 3) / 3
    cell, count = shell * (TILTS * FINE) + column, RADII * TILTS * FINE
    # A cone fills the shells below its end, and a part of its end's own.
    ends = np.bincount(cell, cone, count).reshape(RADII, TILTS, FINE)
    below = np.cumsum(ends[::-1], axis=0)[::-1] - ends
    partly = np.bincount(cell, cone * (np.minimum(distance, radius) ** 3 - edges[shell] ** 3) / 3, count)
    volumes = below * shells[:, None, None] + partly.reshape(RADII, TILTS, FINE)
    total, area = volumes.sum(), np.linalg.norm(area_vectors, axis=1).sum()
    return volumes / total if abs(total) > LEAST_VOLUME * area**1.5 else np.full_like(volumes, np.nan)


def _barycentres(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates along two edges of the centres of the ``count^2`` equal parts of a triangle."""
    row, column = (index.ravel() for index in np.indices((count, 2 * count)))
    inside = column < 2 * (count - row) - 1
    row, column = row[inside], column[inside]
    third = np.where(column % 2, 2 / 3, 1 / 3)
    return (column // 2 + third) / count, (row + third) / count


# The threshold lets pairs through that are about as different as those at the threshold of the cylindrical grid: scores
# of the two are 0.032 and 4 % of the size together on the registered crane capture.
DESCRIPTOR = Descriptor("", 0.03, 64, False, fit, shape, describe, correlation.compare)
