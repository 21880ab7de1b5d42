"""A captured frame made fit for tracking: welded, without debris, with normals that defects do not spoil."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.geometry.components import face_components, weld


@dataclass(frozen=True)
class CleanSurface:
    """The part of a frame that counts.

    Attributes
    ----------
    vertices : (n, 3) float64, welded, every one used by ``faces``
    faces : (m, 3) int32, all captured faces of significant components that did not collapse in welding
    face_index : (m,) which face of the captured frame each one is
    geometric : (m,) bool, False for zero-area faces and for repeats of a face already there (front and back)
    """

    vertices: np.ndarray
    faces: np.ndarray
    face_index: np.ndarray
    geometric: np.ndarray


def clean_surface(vertices: np.ndarray, faces: np.ndarray, debris_share: float = 0.01) -> CleanSurface:
    """Weld, drop components below ``debris_share`` of the area, mark what carries no geometry.

    ValueError where ``vertices`` is not (n, 3) finite, ``faces`` not (m, 3) in range, or no area is left.
    """
    vertices, faces = np.asarray(vertices), np.asarray(faces)
    if vertices.dtype.kind not in "fiu":
        raise ValueError(f"vertices: expected real numbers, got {vertices.dtype}")
    vertices = vertices.astype(np.float64)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise ValueError(f"vertices: expected finite (n, 3), got shape {vertices.shape} or NaN or infinity")
    if faces.ndim != 2 or faces.shape[1] != 3 or not np.issubdtype(faces.dtype, np.integer) or len(faces) == 0:
        raise ValueError(f"faces: expected (m, 3) integers with m > 0, got {faces.dtype} {faces.shape}")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ValueError(f"faces: expected indices in 0..{len(vertices) - 1}, got {faces.min()}..{faces.max()}")
    points, welded, _ = weld(vertices, faces)
    collapsed = (welded[:, 0] == welded[:, 1]) | (welded[:, 1] == welded[:, 2]) | (welded[:, 2] == welded[:, 0])
    areas = 0.5 * np.linalg.norm(face_normals(points, welded), axis=1)
    if not areas.any():
        raise ValueError("faces: expected a surface with area, got zero-area triangles only")
    part = face_components(len(points), welded)
    share = np.bincount(part, areas)[part]
    kept = np.flatnonzero((share >= debris_share * areas.sum()) & ~collapsed)
    used = np.zeros(len(points), bool)
    used[welded[kept]] = True
    compact = (np.cumsum(used) - 1).astype(np.int32)[welded[kept]]
    points = points[used]
    low, middle, high = np.sort(compact, axis=1).astype(np.int64).T
    _, first = np.unique((low << 42) + (middle << 21) + high, return_index=True)
    geometric = np.zeros(len(compact), bool)
    geometric[first] = True
    geometric &= areas[kept] > 5e-7 * _longest_squared(points, compact)
    return CleanSurface(points, compact, kept, geometric)


def _longest_squared(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Squared length (m,) of every triangle's longest edge."""
    a, b, c = vertices[faces[:, 0]], vertices[faces[:, 1]], vertices[faces[:, 2]]
    return np.maximum.reduce([np.einsum("fx,fx->f", side, side) for side in (b - a, c - b, a - c)])


def face_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals (m, 3) whose lengths are twice the triangles' areas."""
    a, b, c = vertices[faces[:, 0]], vertices[faces[:, 1]], vertices[faces[:, 2]]
    u, v = b - a, c - a
    normals = np.empty_like(u)
    normals[:, 0] = u[:, 1] * v[:, 2] - u[:, 2] * v[:, 1]
    normals[:, 1] = u[:, 2] * v[:, 0] - u[:, 0] * v[:, 2]
    normals[:, 2] = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return normals


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) at length 1; zero vectors stay zero."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)


def vertex_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """A third of the area of each vertex's faces (n,)."""
    areas = 0.5 * np.linalg.norm(face_normals(vertices, faces), axis=1)
    return np.bincount(faces.ravel(), np.repeat(areas / 3, 3), minlength=len(vertices))
