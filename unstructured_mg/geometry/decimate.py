"""Fewer triangles on the same texture atlas."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg import _native

# What a metre of texture that slides on the surface counts beside a metre by which the surface is missed.
SLIDING = 0.5
# Of the squares on seams and on open edges, beside the areas of faces: how firmly their lines are kept.
SEAM, BOUNDARY = 1.0, 10.0


@dataclass(frozen=True)
class Decimation:
    """What is left of a mesh: nothing has moved, so it fits every pose and every texture of the same connectivity.

    Attributes
    ----------
    faces : (f, 3) int32 into the vertices that are left
    face_uv : (f, 3) int32 into the uvs that are left; (0, 3) where there were none
    vertex_index : (w,) which vertex each one left was
    uv_index : (r,) which uv each one left was
    face_index : (f,) which face each one was, for its material
    """

    faces: np.ndarray
    face_uv: np.ndarray
    vertex_index: np.ndarray
    uv_index: np.ndarray
    face_index: np.ndarray


def decimate(
    vertices: np.ndarray,
    faces: np.ndarray,
    goal: int,
    uv: np.ndarray | None = None,
    face_uv: np.ndarray | None = None,
    face_material: np.ndarray | None = None,
) -> Decimation:
    """Leave out vertices, one at a time, until at most ``goal`` faces are left.

    A vertex vanishes by moving onto a neighbour: the cheapest one first, by quadric error metrics (Garland and Heckbert
    1997), with quadrics for the sliding texture (the same, 1998). The cost of moving u onto v is::

        sum over faces that have been collapsed into u and v of
            area (n . p_v + d)^2 + area (SLIDING metres-a-uv)^2 |g p_v + e - uv_v|^2

    with n, d the face's plane and g, e its affine map from space to uv; open edges and seams add planes that stand
    on them. Seams stay seams: a vertex on one moves along it only, on both sides alike, and where three charts or more
    meet it stays. So more faces may be left than were asked for, where an atlas has many charts or a mesh many parts.
    Where a straightened seam leaves its chart, the colour between the charts shows: single dots down to a tenth of a
    capture's faces, spots below. Wide margins around the charts mend it.

    Parameters
    ----------
    vertices : (n, 3) float64, or (poses, n, 3): the connectivity must serve all of them (the texture the first)
    faces : (m, 3) int32
    goal : faces, at least 1
    uv, face_uv : (q, 2) and (m, 3) int32, or None
    face_material : (m,) int32 or None: borders between materials are seams

    Raises
    ------
    ValueError
        For shapes or indices that do not fit together, coordinates that are not finite, or a goal below 1.
    """
    poses = np.ascontiguousarray(vertices if np.ndim(vertices) == 3 else np.asarray(vertices)[None], np.float64)
    if poses.ndim != 3 or poses.shape[2] != 3 or len(poses) == 0 or not np.isfinite(poses).all():
        raise ValueError(f"vertices: expected finite (n, 3) or (poses, n, 3), got shape {np.shape(vertices)} or NaN")
    left: np.ndarray = np.array(faces, np.int32, order="C")
    _check_indices("faces", left, poses.shape[1], len(left))
    if goal < 1:
        raise ValueError(f"goal: expected 1 face or more, got {goal}")
    textured = uv is not None and face_uv is not None and len(face_uv) > 0
    if uv is not None and face_uv is not None and textured:
        _check_indices("face_uv", np.asarray(face_uv), len(uv), len(left))
        if np.shape(uv)[1:] != (2,) or not np.isfinite(uv).all():
            raise ValueError(f"uv: expected finite (q, 2), got shape {np.shape(uv)} or NaN")
        corners, values = np.asarray(face_uv, np.int64), np.asarray(uv, np.float64)
    else:
        corners, values = left.astype(np.int64), np.zeros((poses.shape[1], 2))
    # A wedge is what a vertex, a uv and a material have in common.
    material = np.zeros(len(left), np.int64) if face_material is None else np.asarray(face_material, np.int64)
    if material.shape != (len(left),):
        raise ValueError(f"face_material: expected ({len(left)},), got {material.shape}")
    keys = np.stack([left.astype(np.int64), corners, np.repeat(material[:, None], 3, axis=1)], axis=2).reshape(-1, 3)
    order = np.lexsort(keys.T[::-1])
    fresh = np.ones(len(keys), bool)
    fresh[1:] = (keys[order][1:] != keys[order][:-1]).any(axis=1)
    wedges: np.ndarray = np.empty(len(keys), np.int32)
    wedges[order] = np.cumsum(fresh, dtype=np.int32) - 1
    uv_of_wedge = keys[order[fresh], 1]
    wedges = wedges.reshape(-1, 3)
    sliding = SLIDING * _metres_a_uv(poses[0], left, values, corners)
    _native.decimate(
        poses, np.ascontiguousarray(values[uv_of_wedge]), left, wedges, len(poses), sliding, SEAM, BOUNDARY, goal
    )
    kept = np.flatnonzero(left[:, 0] >= 0)
    vertex_index, compact = np.unique(left[kept], return_inverse=True)
    uv_index, compact_uv = np.unique(uv_of_wedge[wedges[kept]], return_inverse=True)
    if not textured:
        uv_index, compact_uv = np.zeros(0, np.int64), np.zeros((0, 3), np.int64)
    return Decimation(
        compact.reshape(-1, 3).astype(np.int32),
        compact_uv.reshape(-1, 3).astype(np.int32),
        vertex_index,
        uv_index,
        kept,
    )


def _metres_a_uv(vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray, face_uv: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    a, b, c = (uv[face_uv[:, i]] for i in range(3))
    covered = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum()
    return float(np.sqrt(area / covered)) if covered > 0 else 0.0


def _check_indices(name: str, indices: np.ndarray, below: int, count: int) -> None:
    if indices.shape != (count, 3) or count == 0:
        raise ValueError(f"{name}: expected ({max(count, 1)}, 3) indices, got shape {indices.shape}")
    if indices.min() < 0 or indices.max() >= below:
        raise ValueError(f"{name}: expected indices in 0..{below - 1}, got {indices.min()}..{indices.max()}")
