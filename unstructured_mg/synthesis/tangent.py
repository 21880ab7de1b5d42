"""Tangent vector fields at vertices: how they turn from vertex to vertex and into faces, and how smooth they are."""

import numpy as np
import scipy.sparse as sp

from unstructured_mg.geometry.normals import face_normals
from unstructured_mg.geometry.tracing import TracingSurface


class TangentFields:
    """Vector fields with two components at every vertex, in an orthonormal frame of its tangent plane.

    Vectors move between planes by the smallest rotation that takes one normal to the other.

    Attributes
    ----------
    axes : (n, 2, 3) float64, the frame of every vertex
    to_corner : (m, 3, 2, 2) float64, vertex components to components in the face's plane, for each corner
    stiffness : (2n, 2n) sparse, ``v^T S v`` is the Dirichlet energy, sum over edges of w |v_j - transported v_i|^2 with
        cotangent weights w; components interleaved
    """

    def __init__(self, vertices: np.ndarray, normals: np.ndarray, tracing: TracingSurface):
        faces = tracing.faces
        self.axes = _frames(normals)
        flat = face_normals(vertices, faces)
        blunt = normals[faces].sum(axis=1)
        flat = np.where((np.linalg.norm(flat, axis=1) > 0.5)[:, None], flat, blunt)
        flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
        x = vertices[faces[:, 1]] - vertices[faces[:, 0]]
        x -= flat * np.einsum("ij,ij->i", x, flat)[:, None]
        x /= np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-300)
        planes = np.stack([x, np.cross(flat, x)], axis=1)
        self.to_corner = np.empty((len(faces), 3, 2, 2))
        for i in range(3):
            turned = _transport(self.axes[faces[:, i]], normals[faces[:, i]], flat)
            self.to_corner[:, i] = np.einsum("fap,fbp->fab", planes, turned)
        self.stiffness = self._stiffness(normals, tracing)

    def _stiffness(self, normals: np.ndarray, tracing: TracingSurface) -> sp.csr_matrix:
        n = len(normals)
        a, b = tracing.faces[:, [1, 2, 0]].ravel(), tracing.faces[:, [2, 0, 1]].ravel()
        # Edges of obtuse corners would push neighbours apart: a little weight keeps the energy positive.
        weight = np.maximum(half_cotangents(tracing).ravel(), 0.01)
        turned = _transport(self.axes[a], normals[a], normals[b])
        carry = np.einsum("eap,ebp->eab", self.axes[b], turned)
        rows, columns, values = [], [], []
        for p in range(2):
            for q in range(2):
                rows += [2 * b + p, 2 * a + q]
                columns += [2 * a + q, 2 * b + p]
                values += [-weight * carry[:, p, q]] * 2
            rows += [2 * a + p, 2 * b + p]
            columns += [2 * a + p, 2 * b + p]
            values += [weight, weight]
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sp.coo_matrix(entries, shape=(2 * n, 2 * n)).tocsr()

    def at_corners(self, field: np.ndarray, faces: np.ndarray) -> np.ndarray:
        """A field (n, 2) as seen from every face's corners (m, 3, 2), as tracing wants it."""
        return np.einsum("fiab,fib->fia", self.to_corner, field[faces])

    def cluster_basis(self, normals: np.ndarray, labels: np.ndarray) -> sp.csr_matrix:
        """Fields ``(2n, 2k)`` that are constant, but for turning with the surface, on each of k clusters of vertices.

        normals (n, 3) float64; labels (n,) in 0..k-1.
        """
        n, count = len(normals), int(labels.max()) + 1
        roots = np.stack([np.bincount(labels, normals[:, i], minlength=count) for i in range(3)], axis=1)
        lengths = np.linalg.norm(roots, axis=1, keepdims=True)
        roots = np.where(lengths > 1e-9, roots / np.maximum(lengths, 1e-9), [1.0, 0.0, 0.0])
        turned = _transport(_frames(roots)[labels], roots[labels], normals)
        blocks = np.einsum("nap,nbp->nab", self.axes, turned)
        columns = (2 * labels[:, None].astype(np.int64) + np.arange(2))[:, None].repeat(2, axis=1)
        return sp.csr_matrix((blocks.ravel(), columns.ravel(), np.arange(0, 4 * n + 1, 2)), shape=(2 * n, 2 * count))


def _frames(normals: np.ndarray) -> np.ndarray:
    """Orthonormal tangent axes (n, 2, 3) of planes with unit normals (n, 3)."""
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=1)


def half_cotangents(tracing: TracingSurface) -> np.ndarray:
    """Half the cotangent ``(m, 3)`` of every corner's angle."""
    squared = tracing.lengths**2
    return (squared.sum(axis=1, keepdims=True) - 2 * squared) / (8 * tracing.areas[:, None])


def _transport(vectors: np.ndarray, origin: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """Tangent vectors (p, k, 3) at unit normals ``origin`` turned by the smallest rotation onto normals ``goal``."""
    along = np.einsum("pkc,pc->pk", vectors, goal)
    share = 1 + np.einsum("pc,pc->p", origin, goal)
    # Opposite normals: any half turn will do; this bound keeps it finite.
    return vectors - (along / np.maximum(share, 1e-6)[:, None])[:, :, None] * (origin + goal)[:, None]
