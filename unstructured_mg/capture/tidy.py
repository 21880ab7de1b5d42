"""From what a mesh file says to arrays that every room can rely on."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg import _native
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.geometry.components import compact, weld_labels


@dataclass(frozen=True)
class Tidied:
    """What was changed between the file and the mesh.

    ``welded`` vertices that became one with another, ``collapsed`` faces left out because a corner was repeated,
    ``repeated`` faces left out because the same three vertices had a face before, ``facing_away`` faces that have a
    twin of opposite orientation and were kept, ``unused`` vertices left out because no face names them, ``untextured``
    faces without uv or image in a frame that has both.
    """

    welded: int
    collapsed: int
    repeated: int
    facing_away: int
    unused: int
    untextured: int


def tidy(raw: RawMesh) -> tuple[TexturedMesh, Tidied]:
    """Make a raw mesh a TexturedMesh, still in the file's unit and axis. Values must be finite.

    - Seams are closed: vertices on the surface's open edges that lie at exactly the same place become one. Vertices
      inside the surface are let alone, so that two that chance to meet in one frame do not change a constant
      connectivity.
    - uvs that repeat one of the same vertex become one, so that a chart's triangles share uvs as they share vertices.
    - Faces that name a vertex twice are left out: they have no area, and the edge they fold away joins their
      neighbours. Faces without area whose corners differ stay.
    - A face on the same three vertices, in the same sense, as one before it is left out. Where at least half of all
      faces have a twin in the opposite sense (a front and a back, which may have vertices of its own), the later of
      each two is left out as well: normals at vertices would cancel to nothing, and no point would be inside. Single
      twins stay: they close a fold.
    - Vertices that no face names are left out: they would count in bounds and floor.
    - Corners without uv, in a mesh that has uvs, get the uv (0, 0); faces without image, in a mesh that has images, get
      the first image and the uv (0, 0).
    """
    faces, welded = _close_seams(raw.vertices, raw.faces)
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    if not whole.any():
        whole[:] = True  # nothing but points and lines: the caller refuses it by its area
    collapsed = int(np.count_nonzero(~whole))
    repeated, away = _twins(faces[whole])
    if _is_front_and_back(repeated, away):
        repeated |= away
        away = np.zeros_like(away)
    kept = np.flatnonzero(whole)[~repeated]
    vertices, faces, used = compact(raw.vertices, faces[kept])
    face_uv, face_image = raw.face_uv[kept], raw.face_image[kept] if raw.images else None
    uv, untextured = raw.uv, 0
    if (face_uv < 0).all():
        uv, face_uv = np.zeros((0, 2)), np.zeros((0, 3), np.int32)
    else:
        lacking = (face_uv < 0).any(axis=1)
        if face_image is not None:
            lacking |= face_image < 0
        untextured = int(np.count_nonzero(lacking))
        uv, face_uv = _join_uv(faces, *_fill_uv(uv, face_uv, lacking))
    if face_image is not None:
        face_image = np.maximum(face_image, 0) if len(raw.images) > 1 else None
    mesh = TexturedMesh(
        vertices=vertices,
        faces=faces,
        uv=uv,
        face_uv=face_uv,
        colors=None if raw.colors is None else raw.colors[used],
        textures=raw.images,
        face_material=face_image,
    )
    unused = len(raw.vertices) - len(vertices) - welded
    return mesh, Tidied(
        welded, collapsed, int(np.count_nonzero(repeated)), int(np.count_nonzero(away)), unused, untextured
    )


def _close_seams(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, int]:
    """Faces with the vertices of equal place on open edges made one (the first of them), and how many vanished.

    Where that shows a front and a back with vertices of their own, those of equal place are made one everywhere.
    """
    labels, count = weld_labels(vertices)
    if count == len(vertices):
        return faces, 0
    first = np.full(count, len(vertices), np.int32)
    np.minimum.at(first, labels, np.arange(len(vertices), dtype=np.int32))
    everywhere = first[labels]
    if _is_front_and_back(*_twins(everywhere[faces])):
        return everywhere[faces], len(vertices) - count
    tails, heads = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    keys = np.minimum(tails, heads).astype(np.int64) * len(vertices) + np.maximum(tails, heads)
    order = np.argsort(keys)
    ordered = keys[order]
    single = np.ones(len(keys), bool)
    single[1:] &= ordered[1:] != ordered[:-1]
    single[:-1] &= ordered[1:] != ordered[:-1]
    on_open_edge = np.zeros(len(vertices), bool)
    on_open_edge[tails[order[single]]] = True
    on_open_edge[heads[order[single]]] = True
    border = np.flatnonzero(on_open_edge)
    first[:] = len(vertices)
    np.minimum.at(first, labels[border], border.astype(np.int32))
    target = np.arange(len(vertices), dtype=np.int32)
    target[border] = first[labels[border]]
    return target[faces], int(np.count_nonzero(target[border] != border))


def _twins(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """``(m,) bool`` twice: faces on the same vertices as an earlier one, in its sense, and in the opposite sense."""
    labels = np.empty(len(faces), np.int32)
    count = _native.weld_rows(np.sort(faces, axis=1).astype(np.float64), labels)
    same, opposite = np.zeros(len(faces), bool), np.zeros(len(faces), bool)
    if count == len(faces):
        return same, opposite
    a, b, c = faces.T
    even = ((a < b) & (b < c)) | ((b < c) & (c < a)) | ((c < a) & (a < b))
    sense = 2 * labels.astype(np.int64) + even
    first_of_set, first_of_sense = np.full(count, len(faces)), np.full(2 * count, len(faces))
    index = np.arange(len(faces))
    np.minimum.at(first_of_set, labels, index)
    np.minimum.at(first_of_sense, sense, index)
    same = first_of_sense[sense] != index
    opposite = ~same & (first_of_set[labels] != index)
    return same, opposite


def _is_front_and_back(repeated: np.ndarray, away: np.ndarray) -> bool:
    """Whether at least half of the faces, repeated ones apart, have a twin of the other sense (``away``: one of each
    two).
    """
    return bool(away.any() and 4 * np.count_nonzero(away) >= np.count_nonzero(~repeated))


def _fill_uv(uv: np.ndarray, face_uv: np.ndarray, lacking: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if not lacking.any():
        return uv, face_uv
    return np.concatenate([uv, [[0.0, 0.0]]]), np.where(lacking[:, None], len(uv), face_uv).astype(np.int32)


def _join_uv(faces: np.ndarray, uv: np.ndarray, face_uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One uv for each vertex and place in the atlas, in order of the file, none unused.

    A file whose uvs are shared between vertices has had equal ones joined by its writer: those are let alone.
    """
    owner = np.empty(len(uv), np.int64)
    owner[face_uv.ravel()] = faces.ravel()
    if (owner[face_uv] == faces).all():
        used = np.zeros(len(uv), bool)
        used[face_uv.ravel()] = True
        owner[~used] = -1
        labels, count = weld_labels(np.column_stack([owner, uv]))
        if count < len(uv):
            first = np.full(count, len(uv), np.int64)
            np.minimum.at(first, labels, np.arange(len(uv)))
            uv, face_uv = uv[first], labels[face_uv]
    uv, face_uv, _ = compact(uv, face_uv)
    return uv, face_uv
