"""Where a frame stands and how much room it takes."""

import numpy as np

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.laplacian import face_areas

# This share of a frame's area may lie outside its extent at each end: stray triangles.
OUTSIDE = 2e-3


def extent(mesh: TexturedMesh) -> np.ndarray:
    """``(5,) float64``: the centre of mass x, y; but for outlying area, radius about it, least and most height.

    The first two are the root, the point on the floor whose path is the actor's way through the room. ValueError where
    the mesh has no area.
    """
    corner_mass = np.repeat(face_areas(mesh.vertices, mesh.faces) / 3, 3)
    mass = np.bincount(mesh.faces.ravel(), corner_mass, minlength=len(mesh.vertices))
    if not mass.sum() > 0:
        raise ValueError("mesh: expected a surface with an area, got none")
    # Not a BLAS product, which rounds otherwise with another number of threads.
    root = (mass[:, None] * mesh.vertices[:, :2]).sum(axis=0) / mass.sum()
    radius = np.hypot(mesh.vertices[:, 0] - root[0], mesh.vertices[:, 1] - root[1])
    height = mesh.vertices[:, 2]
    return np.array(
        [
            *root,
            _quantile(radius, mass, 1 - OUTSIDE),
            _quantile(height, mass, OUTSIDE),
            _quantile(height, mass, 1 - OUTSIDE),
        ]
    )


def actor_size(extents: np.ndarray) -> float:
    """Metres: the median over frames (n, 5) of the larger of height and width."""
    return float(np.median(np.maximum(extents[:, 4] - extents[:, 3], 2 * extents[:, 2])))


def _quantile(values: np.ndarray, weights: np.ndarray, share: float) -> float:
    """Value below which ``share`` of the weight lies, to 1 / 4096 of the range: a sort takes ten times as long."""
    low, high = values.min(), values.max()
    step = (high - low) / 4096 or 1.0
    cells = np.minimum((values - low) / step, 4095).astype(np.intp)
    total = np.cumsum(np.bincount(cells, weights, 4096))
    return float(low + step * (np.searchsorted(total, share * total[-1]) + 1))
