"""Where a body stands."""

import numpy as np

from unstructured_mg.geometry.laplacian import face_areas


def floor_centre(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """``(2,) float64`` metres: the centre of the surface's area, projected onto the floor.

    ``vertices`` (n, 3) and ``faces`` (m, 3). The same for every meshing of a surface; a surface without area gives the
    mean of its vertices.
    """
    areas = face_areas(vertices, faces)
    if not areas.sum() > 0:
        return np.asarray(vertices[:, :2].mean(axis=0))
    return np.asarray(areas @ vertices[faces, :2].mean(axis=1) / areas.sum())
