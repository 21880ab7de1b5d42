"""Connected components, welding and boundary of triangle meshes."""

import numpy as np

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
    """Component label ``(m,) int32`` of every face; faces that share a vertex belong together.

    Labels count from 0 by each component's first vertex. Raises ValueError where a face names a vertex out of range.
    """
    labels = np.empty(vertex_count, np.int32)
    count = _native.vertex_components(np.ascontiguousarray(faces, np.int32), labels)
    label = labels[faces[:, 0]]
    has_face = np.zeros(count, bool)
    has_face[label] = True
    return (np.cumsum(has_face, dtype=np.int32) - 1)[label]


def significant_faces(vertices: np.ndarray, faces: np.ndarray, share: float = 0.01) -> np.ndarray:
    """``(m,) bool``: faces of components (after welding) that hold at least ``share`` of the whole area."""
    _, welded_faces, _ = weld(vertices, faces)
    labels = face_components(len(vertices), welded_faces)
    areas = np.bincount(labels, face_areas(vertices, faces))
    return areas[labels] >= share * areas.sum()
