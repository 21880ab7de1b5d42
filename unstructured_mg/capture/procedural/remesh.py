"""Re-meshing of a closed surface with another connectivity every time, keeping each vertex's material point."""

import numpy as np

from unstructured_mg import _native
from unstructured_mg.geometry.closest import ClosestPoints


def opposite_half_edges(faces: np.ndarray) -> np.ndarray:
    """The corner table (3 m,) int32 of closed manifold faces (m, 3): half-edge 3 f + c seen from the other face.

    Raises ValueError where an edge does not have exactly two faces that run it in opposite directions.
    """
    start, end = faces.ravel().astype(np.int64), np.roll(faces, -1, axis=1).ravel().astype(np.int64)
    count = int(faces.max()) + 1
    order, mirror = np.argsort(start * count + end, kind="stable"), np.argsort(end * count + start, kind="stable")
    key = (start * count + end)[order]
    if (key != (end * count + start)[mirror]).any() or (np.diff(key) == 0).any():
        raise ValueError("faces: expected a closed, consistently oriented manifold")
    opposite = np.empty(len(start), np.int32)
    opposite[order] = mirror
    return opposite


def flip_edges(faces: np.ndarray, opposite: np.ndarray, points: np.ndarray, passes: int) -> int:
    """Flip edges in place towards the Delaunay condition; returns how many. ``faces`` and ``opposite`` change."""
    return int(_native.flip_edges(faces, opposite, np.ascontiguousarray(points), passes))


def coarsen(
    faces: np.ndarray, opposite: np.ndarray, points: np.ndarray, sizes: np.ndarray, seed: int, target: int
) -> tuple[np.ndarray, np.ndarray]:
    """Collapse random short edges of a closed manifold until ``target`` faces are left.

    Parameters
    ----------
    faces, opposite : (m, 3) and (3 m,) int32 corner table; not changed
    points : (n, 3) float64
    sizes : (n,) float64 edge length wanted around each vertex, metres
    seed : chooses the order of collapses
    target : number of faces to stop at

    Returns
    -------
    kept : (k,) int64 indices of the points that are left
    faces : (about target, 3) int32 into ``kept``
    """
    faces, opposite = np.array(faces, np.int32), np.array(opposite, np.int32)
    _native.coarsen(faces, opposite, np.ascontiguousarray(points), np.ascontiguousarray(sizes), seed, target)
    faces = faces[faces[:, 0] >= 0]
    kept, renamed = np.unique(faces, return_inverse=True)
    return kept, renamed.reshape(-1, 3).astype(np.int32)


def remesh(
    surface: ClosestPoints, opposite: np.ndarray, sizes: np.ndarray, seed: int, target: int, rounds: int = 2
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A new triangulation of ``surface``: random collapses, then relaxation along the surface with edge flips.

    ``opposite`` is the corner table of the surface's faces; ``sizes``, ``seed`` and ``target`` as in ``coarsen``.

    Returns
    -------
    faces : (about target, 3) int32, closed, of the surface's genus, in a random order
    face : (n,) int64 the surface's face that holds each new vertex
    weights : (n, 3) float64 barycentric weights on that face, none negative, sum 1
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    kept, faces = coarsen(surface.faces, opposite, surface.vertices, sizes, int(generator.integers(2**63)), target)
    points = surface.vertices[kept]
    table = opposite_half_edges(faces)
    for step in range(rounds + 1):
        flip_edges(faces, table, points, 4)
        if step < rounds:
            points = points + 0.5 * (_ring_centres(points, faces) - points)
        _, face, points = surface.query(points)
    weights = np.clip(surface.barycentric(face, points), 0.0, 1.0)
    weights /= weights.sum(1, keepdims=True)
    shuffled = generator.permutation(len(points))
    rank = np.empty_like(shuffled)
    rank[shuffled] = np.arange(len(points))
    faces = rank[faces][generator.permutation(len(faces))].astype(np.int32)
    return faces, face[shuffled], weights[shuffled]


def _ring_centres(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area-weighted mean (n, 3) of the centres of each vertex's triangles."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    centres = (a + b + c) / 3
    corners = faces.ravel()
    total = np.bincount(corners, np.repeat(areas, 3), len(points))
    sums = np.stack([np.bincount(corners, np.repeat(areas * centres[:, i], 3), len(points)) for i in range(3)], 1)
    return sums / total[:, None]
