"""Surfaces as a web page draws them: one vertex a corner of the atlas, whole numbers, neighbours beside each other."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from unstructured_mg.playback.site_codec import columns

# Steps of a coordinate: what fits into 16 bits.
STEPS = 65535


@dataclass(frozen=True)
class Drawing:
    """The faces of a surface over corners: pairs of a vertex and a uv that some face uses.

    Attributes
    ----------
    vertex_of : (c,) int64, each corner's vertex
    uv_of : (c,) int64, each corner's uv; empty without uv
    faces : (m, 3) int64 over the corners, sorted for small differences, faces of one material together
    faces_of_material : faces of each material, in the order of ``faces``
    source_face : (m,) int64, where each face stands in the surface that this was made from
    """

    vertex_of: np.ndarray
    uv_of: np.ndarray
    faces: np.ndarray
    faces_of_material: tuple[int, ...]
    source_face: np.ndarray


def draw_order(faces: np.ndarray, face_uv: np.ndarray, face_material: np.ndarray | None, materials: int) -> Drawing:
    """Corners and faces of a surface in an order in which neighbours on it are mostly neighbours in the file.

    Corners follow each other as the reverse Cuthill-McKee order of the surface's edges has them, faces by their first
    corner; every face keeps its orientation.
    """
    vertex, textured = faces.astype(np.int64).ravel(), len(face_uv) > 0
    if textured:
        count = int(face_uv.max()) + 1
        pairs, corner = np.unique(vertex * count + face_uv.ravel(), return_inverse=True)
        vertex_of, uv_of = pairs // count, pairs % count
    else:
        vertex_of, corner = np.unique(vertex, return_inverse=True)
        uv_of = np.zeros(0, np.int64)
    around = corner.reshape(-1, 3)
    ends = np.concatenate([around, np.roll(around, 1, axis=1)]).ravel()
    starts = np.concatenate([np.roll(around, 1, axis=1), around]).ravel()
    edges = coo_matrix((np.ones(len(ends), np.int8), (starts, ends)), shape=(len(vertex_of),) * 2).tocsr()
    order = reverse_cuthill_mckee(edges, symmetric_mode=True).astype(np.int64)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    around = place[around]
    first = around.argmin(axis=1)
    around = np.take_along_axis(around, (first[:, None] + np.arange(3)) % 3, axis=1)
    material = np.zeros(len(faces), np.int64) if face_material is None else face_material
    chosen = np.lexsort((around[:, 2], around[:, 1], around[:, 0], material))
    counts = np.bincount(material, minlength=max(materials, 1))
    return Drawing(
        vertex_of[order], uv_of[order] if textured else uv_of, around[chosen], tuple(counts.tolist()), chosen
    )


def face_section(drawing: Drawing) -> bytes:
    """The faces' columns: first corner, second less first, third less second (both modulo the type's size)."""
    kind = np.uint16 if len(drawing.vertex_of) <= STEPS else np.uint32
    first, second, third = drawing.faces.T
    return columns(np.stack([first, second - first, third - second], axis=1).astype(kind))


def quantised(points: np.ndarray, precision: float) -> tuple[np.ndarray, np.ndarray, float]:
    """(..., c) numbers as uint16 steps above their lowest: (steps, lowest (c,), size of a step)."""
    axes = tuple(range(points.ndim - 1))
    low = points.min(axis=axes)
    step = max(precision, float((points.max(axis=axes) - low).max()) / STEPS)
    return np.rint((points - low) / step).astype(np.uint16), low, step
