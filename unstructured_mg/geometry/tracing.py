"""Straightest paths and streamlines on a triangle surface: faces are unfolded into the plane one after the other.

The surface is intrinsic: only edge lengths and neighbours count. Lengths are lengthened by one tiny common amount
until every face has area (Sharp and Crane 2020, doi 10.1145/3386569.3392430), so slivers cannot stop a path.
"""

import numpy as np

from unstructured_mg import _native
from unstructured_mg.geometry.halfedges import match_halfedges


class TracingSurface:
    """A surface that points can move on.

    In every face's plane corner 0 is the origin, corner 1 lies on the first axis, and corner 2 above it.

    Attributes
    ----------
    faces : (m, 3) int32
    neighbor, entry : (m, 3) int32, see ``match_halfedges``
    lengths : (m, 3) float64, of the edge opposite each corner
    layout : (m, 3, 2) float64, the corners in the face's plane
    areas : (m,) float64
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        vertices = np.asarray(vertices, dtype=np.float64)
        faces = np.ascontiguousarray(faces, dtype=np.int32)
        if faces.ndim != 2 or faces.shape[1:] != (3,) or len(faces) == 0:
            raise ValueError(f"faces: expected (m, 3) with m > 0, got {faces.shape}")
        if faces.min() < 0 or faces.max() >= len(vertices):
            raise ValueError(f"faces: expected indices in 0..{len(vertices) - 1}")
        self.faces = faces
        self.neighbor, self.entry = match_halfedges(vertices, faces)
        a, b, c = (vertices[faces[:, i]] for i in range(3))
        lengths = np.stack([np.linalg.norm(d, axis=1) for d in (c - b, a - c, b - a)], axis=1)
        slack = lengths.sum(axis=1) - 2 * lengths.max(axis=1)
        self.lengths = lengths + max(0.0, float((1e-5 * lengths.mean() - slack).max()))
        l0, l1, l2 = self.lengths.T
        x = (l1**2 - l0**2 + l2**2) / (2 * l2)
        y = np.sqrt(np.maximum(l1**2 - x**2, 0))
        self.layout = np.zeros((len(faces), 3, 2))
        self.layout[:, 1, 0], self.layout[:, 2, 0], self.layout[:, 2, 1] = l2, x, y
        self.areas = 0.5 * l2 * y
        zero = np.zeros_like(x)
        self._to_weights = np.stack([1 / l2, -x / (l2 * y), zero, 1 / y], axis=1)
        self._turn = self._turns()

    def _turns(self) -> np.ndarray:
        edges = self.layout[:, [2, 0, 1]] - self.layout[:, [1, 2, 0]]
        edges /= self.lengths[:, :, None]
        across = edges[np.maximum(self.neighbor, 0), self.entry]
        # The neighbour runs through the shared edge the other way: turn this face's direction onto minus its.
        cosine = -(edges * across).sum(axis=2)
        sine = -(edges[:, :, 0] * across[:, :, 1] - edges[:, :, 1] * across[:, :, 0])
        return np.ascontiguousarray(np.stack([cosine, sine], axis=2))

    @property
    def tables(self) -> tuple[int, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """What the kernels of native/trace.c take first."""
        return len(self.faces), self.neighbor, self.entry, self._to_weights, self._turn

    def gradients(self) -> np.ndarray:
        """Gradients ``(m, 3, 2)`` of the three hat functions in each face's plane."""
        second, third = self._to_weights[:, :2], self._to_weights[:, 2:]
        return np.stack([-second - third, second, third], axis=1)

    def displace(
        self, face: np.ndarray, weights: np.ndarray, displacement: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Move points straight on over edges; they stop at a boundary.

        face (p,) int, weights (p, 3) barycentric, displacement (p, 2) in the planes of their faces, same unit as the
        vertices. Returns face (p,) int32 and weights (p, 3) float64.
        """
        face, weights = self._points(face, weights)
        face, weights = face.copy(), weights.copy()
        displacement = np.ascontiguousarray(displacement, dtype=np.float64)
        _native.trace_displacements(*self.tables, len(face), face, weights, displacement)
        return face, weights

    def streamlines(
        self, field: np.ndarray, face: np.ndarray, weights: np.ndarray, time: float, steps: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Follow a field through points, in ``steps`` equal steps (midpoint rule) over ``time``.

        field : (m, 3, 2) float64, the vector at every face's corners in the face's plane, linear between
        face (p,) int, weights (p, 3) float64 : where the streamlines start
        Returns face (steps, p) int32 and weights (steps, p, 3) float64 after 1 .. steps steps.
        """
        face, weights = self._points(face, weights)
        field = np.ascontiguousarray(field, dtype=np.float64)
        faces_out = np.empty((steps, len(face)), np.int32)
        weights_out = np.empty((steps, len(face), 3))
        _native.trace_streamlines(
            *self.tables, field, len(face), face, weights, time / steps, steps, faces_out, weights_out
        )
        return faces_out, weights_out

    def _points(self, face: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        face = np.ascontiguousarray(face, dtype=np.int32)
        weights = np.ascontiguousarray(weights, dtype=np.float64)
        if weights.shape != (len(face), 3):
            raise ValueError(f"weights: expected shape {(len(face), 3)}, got {weights.shape}")
        return face, weights
