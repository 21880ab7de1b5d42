"""Split long edges, so that vertex signals can hold the detail of a texture (P A.4, first step)."""

import numpy as np
import scipy.sparse as sp


def refine(
    vertices: np.ndarray, faces: np.ndarray, corners: np.ndarray, longest: float, most_faces: int = 2_000_000
) -> tuple[sp.csr_matrix, np.ndarray, np.ndarray]:
    """Split edges at their middle until none is longer than ``longest`` (or there would be over ``most_faces``).

    Parameters
    ----------
    vertices : (n, 3) float64
    faces : (m, 3) int32
    corners : (m, 3, d) float64, any values at face corners, carried along linearly
    longest : same unit as the vertices

    Returns
    -------
    lift : (k, n) sparse, new vertices as combinations of old ones: ``lift @ vertices``
    faces : (r, 3) int32
    corners : (r, 3, d) float64
    """
    n = len(vertices)
    lift = sp.identity(n, format="csr")
    while True:
        starts, ends = faces[:, [1, 2, 0]], faces[:, [2, 0, 1]]
        lengths = np.linalg.norm(vertices[ends] - vertices[starts], axis=2)
        split = lengths > longest
        if not split.any() or len(faces) + split.sum() > most_faces:
            return lift, faces.astype(np.int32), corners
        low, high = np.minimum(starts, ends).astype(np.int64), np.maximum(starts, ends).astype(np.int64)
        keys, inverse = np.unique((low * len(vertices) + high)[split], return_inverse=True)
        parents = np.stack([keys // len(vertices), keys % len(vertices)], axis=1)
        middle = np.full(split.shape, -1, np.int64)
        middle[split] = len(vertices) + inverse.reshape(-1)
        half = sp.csr_matrix(
            (np.full(2 * len(keys), 0.5), parents.ravel(), np.arange(0, 2 * len(keys) + 1, 2)),
            shape=(len(keys), len(vertices)),
        )
        lift = sp.vstack([lift, half @ lift], format="csr")
        vertices = np.concatenate([vertices, vertices[parents].mean(axis=1)])
        faces, corners = _split_faces(vertices, faces, corners, middle)


def _split_faces(
    vertices: np.ndarray, faces: np.ndarray, corners: np.ndarray, middle: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Faces after their marked edges (``middle`` >= 0, opposite corner i) got a vertex in the middle."""
    marked = middle >= 0
    number = marked.sum(axis=1)
    # Turn every face so that its only marked edge, or its only unmarked one, lies opposite corner 0.
    odd = np.where(number == 1, marked.argmax(axis=1), np.where(number == 2, (~marked).argmax(axis=1), 0))
    turned = (odd[:, None] + np.arange(3)) % 3
    faces, middle = np.take_along_axis(faces.astype(np.int64), turned, 1), np.take_along_axis(middle, turned, 1)
    corners = np.take_along_axis(corners, turned[:, :, None], 1)
    ids = np.concatenate([faces, middle], axis=1)
    values = np.concatenate([corners, 0.5 * (corners[:, [1, 2, 0]] + corners[:, [2, 0, 1]])], axis=1)
    # Columns 0..2 are the corners, 3..5 the middles of the edges opposite them.
    two = number == 2
    across = np.linalg.norm(vertices[faces[:, 1]] - vertices[middle[:, 1]], axis=1)
    other = np.linalg.norm(vertices[faces[:, 2]] - vertices[middle[:, 2]], axis=1)
    straight = across <= other
    patterns = (
        (number == 0, [(0, 1, 2)]),
        (number == 1, [(0, 1, 3), (0, 3, 2)]),
        (two & straight, [(0, 5, 4), (5, 1, 4), (1, 2, 4)]),
        (two & ~straight, [(0, 5, 4), (5, 1, 2), (5, 2, 4)]),
        (number == 3, [(0, 5, 4), (5, 1, 3), (4, 3, 2), (3, 4, 5)]),
    )
    new_faces, new_values, parent = [], [], []
    for chosen, triangles in patterns:
        rows = np.flatnonzero(chosen)
        for triangle in triangles:
            new_faces.append(ids[rows][:, triangle])
            new_values.append(values[rows][:, triangle])
            parent.append(rows)
    # Children stay together, in the order of their parents.
    order = np.argsort(np.concatenate(parent), kind="stable")
    return np.concatenate(new_faces)[order], np.concatenate(new_values)[order]
