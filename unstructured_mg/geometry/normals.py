"""Unit normals of triangle meshes."""

import numpy as np

from unstructured_mg import _native


def face_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals ``(m, 3) float64``; zero where a face has no area."""
    a, b, c = vertices[faces[:, 0]], vertices[faces[:, 1]], vertices[faces[:, 2]]
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area-weighted unit normals ``(n, 3) float64``; zero where they cancel or no face has area.

    vertices (n, 3) float64, faces (m, 3) int32; IndexError where a face names a vertex out of range.
    """
    normals = np.empty((len(vertices), 3))
    vertices, faces = np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(faces, np.int32)
    _native.area_normals(vertices, faces, normals)
    return normals
