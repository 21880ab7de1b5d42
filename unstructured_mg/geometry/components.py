"""Connected components, welding and boundary of triangle meshes."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from unstructured_mg.geometry.laplacian import face_areas


def weld(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Make vertices of equal position one.

    Returns the kept vertices (w, 3) in order of first use by index, faces (m, 3) int32 into them, and for every input
    vertex its welded index (n,) int32. Faces are neither dropped nor reordered.
    """
    _, first, inverse = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    welded = rank[inverse.reshape(-1)].astype(np.int32)
    return vertices[first[order]], welded[faces], welded


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
