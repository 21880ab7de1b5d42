"""Connected components, welding and boundary of triangle meshes."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from unstructured_mg import _native
from unstructured_mg.geometry.laplacian import face_areas


def weld_labels(rows: np.ndarray) -> tuple[np.ndarray, int]:
    """Number equal rows alike: labels ``(n,) int32`` in order of first use, and how many differ. ``rows`` (n, 3),
    finite.
    """
    labels = np.empty(len(rows), np.int32)
    return labels, _native.weld_rows(np.ascontiguousarray(rows, np.float64), labels)


def weld(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Make vertices of equal position one.

    Returns the kept vertices (w, 3) in order of first use by index, faces (m, 3) int32 into them, and for every input
    vertex its welded index (n,) int32. Faces are neither dropped nor reordered.
    """
    welded, count = weld_labels(vertices)
    first = np.full(count, len(vertices), np.int64)
    np.minimum.at(first, welded, np.arange(len(vertices)))
    return vertices[first], welded[faces], welded


def compact(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Leave out the vertices that no face names: the others in their order, faces into them, and their indices
    before.
    """
    used = np.zeros(len(vertices), bool)
    used[faces.ravel()] = True
    kept = np.flatnonzero(used)
    if len(kept) == len(vertices):
        return vertices, faces, kept
    rank = np.cumsum(used, dtype=np.int32) - 1
    return vertices[kept], rank[faces].astype(np.int32), kept


def face_components(vertex_count: int, faces: np.ndarray) -> np.ndarray:
    """Component label ``(m,) int32`` of every face; faces that share a vertex belong together."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    graph = sp.coo_matrix((np.ones(len(edges), np.int8), (edges[:, 0], edges[:, 1])), (vertex_count, vertex_count))
    _, labels = connected_components(graph, directed=False)
    _, compact = np.unique(labels[faces[:, 0]], return_inverse=True)
    return compact.reshape(-1).astype(np.int32)


def significant_faces(vertices: np.ndarray, faces: np.ndarray, share: float = 0.01) -> np.ndarray:
    """``(m,) bool``: faces of components (after welding) that hold at least ``share`` of the whole area."""
    _, welded_faces, _ = weld(vertices, faces)
    labels = face_components(len(vertices), welded_faces)
    areas = np.bincount(labels, face_areas(vertices, faces))
    return areas[labels] >= share * areas.sum()
