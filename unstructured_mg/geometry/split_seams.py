"""Meshes for formats in which a vertex has one uv."""

import numpy as np


def split_seams(faces: np.ndarray, face_uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One vertex for each (vertex, uv) that a corner names.

    Parameters
    ----------
    faces : (m, 3) int32
    face_uv : (m, 3) int32, or (0, 3) where there are no uvs: then vertices stay as they are

    Returns
    -------
    vertex_index : (p,) int64, the vertex that each new one was; ordered by it, then by uv
    uv_index : (p,) int64, its uv; (0,) where there are none
    faces : (m, 3) int32 into the new vertices
    """
    if len(face_uv) == 0:
        used, compact = np.unique(faces, return_inverse=True)
        return used.astype(np.int64), np.zeros(0, np.int64), compact.reshape(-1, 3).astype(np.int32)
    many = int(face_uv.max(initial=0)) + 1
    pairs, compact = np.unique(faces.astype(np.int64) * many + face_uv, return_inverse=True)
    return pairs // many, pairs % many, compact.reshape(-1, 3).astype(np.int32)
