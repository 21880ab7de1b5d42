"""Optical flow between two signals on one surface, coarse to fine (P section 6.3, A.4)."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from unstructured_mg import _native
from unstructured_mg.geometry.clusters import cluster_vertices
from unstructured_mg.geometry.conjugate import TwoLevel, conjugate_gradients
from unstructured_mg.geometry.tracing import TracingSurface
from unstructured_mg.synthesis.tangent import TangentFields, half_cotangents
from unstructured_mg.synthesis.texture_options import TextureOptions

# Width of the clusters of the coarse level of solvers, as a share of the square root of the area.
CLUSTER_WIDTH = 0.023
# Steps of the streamline along half the flow, at each level.
LEVEL_STEPS = 4


@dataclass(frozen=True)
class Flow:
    """A flow field, and how well it explains one signal's change into the other.

    Attributes
    ----------
    corners : (m, 3, 2) float64, metres, the field at every face's corners in the face's plane
    field : (n, 2) float64, metres, in the vertices' tangent frames
    confidence : (n,) float64 in 0..1; the field is scaled by it: 0 where flow cannot explain the change
    residual_before, residual_after : rms difference of the signals in grey levels, unmoved and moved half way each
    unexplained : share of the area whose confidence is below a half
    """

    corners: np.ndarray
    field: np.ndarray
    confidence: np.ndarray
    residual_before: float
    residual_after: float
    unexplained: float


class FlowSolver:
    """Everything of a flow that depends on the surface only; ``estimate`` serves any two signals on it.

    vertices, normals (n, 3) float64; tracing: the surface they belong to.
    """

    def __init__(self, vertices: np.ndarray, normals: np.ndarray, tracing: TracingSurface):
        self.tracing = tracing
        self.count = len(vertices)
        self.fields = TangentFields(vertices, normals, tracing)
        faces = tracing.faces
        self.area = float(tracing.areas.sum())
        self.masses = np.bincount(faces.ravel(), np.repeat(tracing.areas / 3, 3), minlength=self.count)
        self.stiffness = _scalar_stiffness(tracing, self.count)
        self._gradients = np.ascontiguousarray(tracing.gradients())
        self._spread = np.ascontiguousarray((self.fields.to_corner / 3).transpose(0, 2, 1, 3).reshape(len(faces), 2, 6))
        labels = cluster_vertices(vertices, faces, CLUSTER_WIDTH * float(np.sqrt(self.area)))
        count = int(labels.max()) + 1
        self._clusters = sp.csr_matrix((np.ones(self.count), (np.arange(self.count), labels)), (self.count, count))
        self._vector_clusters = self.fields.cluster_basis(normals, labels)
        self._sum_pattern()

    def _sum_pattern(self) -> None:
        """One sparsity pattern for smoothness and data, and where each face's entries go in it."""
        faces = self.tracing.faces
        dofs = (2 * faces[:, :, None] + np.arange(2)).reshape(len(faces), 6)
        rows, columns = np.repeat(dofs, 6, axis=1).ravel(), np.tile(dofs, (1, 6)).ravel()
        size = 2 * self.count
        # Summed ones cannot cancel: SciPy would drop entries that do.
        pattern = sp.coo_matrix((np.ones(len(rows)), (rows, columns)), (size, size)).tocsr()
        pattern.sort_indices()
        key = np.repeat(np.arange(size, dtype=np.int64), np.diff(pattern.indptr)) * size + pattern.indices
        self._slot = np.searchsorted(key, rows.astype(np.int64) * size + columns)
        smooth = self.fields.stiffness.tocoo()
        place = np.searchsorted(key, smooth.row.astype(np.int64) * size + smooth.col)
        values = np.bincount(place, smooth.data, minlength=len(key))
        # Fields on loose scraps of surface cost no energy at all: a little of their size holds them still.
        diagonal = np.searchsorted(key, np.arange(size, dtype=np.int64) * (size + 1))
        values[diagonal] += 1e-3 * np.repeat(self.masses / self.area, 2) + 1e-9 * smooth.diagonal()
        self._smooth = sp.csr_matrix((values, pattern.indices, pattern.indptr), shape=(size, size))
        self._dofs = dofs

    def smooth(self, signals: np.ndarray, weight: float, tolerance: float) -> np.ndarray:
        """Minimise ``|s - signal|^2_M + weight |grad s|^2`` (P eq. 4) for signals (n, d); weight in square metres."""
        matrix = (sp.diags(self.masses) + weight * self.stiffness).tocsr()
        # Wide smoothing couples far vertices; narrow smoothing hardly changes the start.
        coarse = TwoLevel(matrix, self._clusters) if weight > 1e-4 * self.area else None
        return conjugate_gradients(matrix, self.masses[:, None] * signals, signals, tolerance, precondition=coarse)

    def estimate(self, start: np.ndarray, end: np.ndarray, options: TextureOptions) -> Flow:
        """The field v that carries ``start`` to ``end`` (n, d), colours in 0..255.

        At each level both smoothed signals meet half way along the field found so far, and a correction w minimises
        (P eq. 6, with plus in front of the smoothness term of eq. 7)
        ``sum over both of int (<grad I, w> - (I_0 - I_1))^2 + epsilon int |grad w|^2``.
        Swapping start and end gives -v.
        """
        field = np.zeros((self.count, 2))
        channels = start.shape[1]
        both = np.concatenate([start, end], axis=1)
        for level in range(options.levels):
            shrink = 4.0**-level
            smoothed = self.smooth(both, options.signal_smoothing * shrink * self.area, options.tolerance)
            first = self.moved(smoothed[:, :channels], field, -0.5)
            second = self.moved(smoothed[:, channels:], field, 0.5)
            field += self._correction(first, second, options.flow_smoothing * shrink, options.tolerance)
        before, after = start - end, self.moved(start, field, -0.5) - self.moved(end, field, 0.5)
        confidence = self._confidence(before, after, field, options.noise)
        kept = field * confidence[:, None]
        left = self.moved(start, kept, -0.5) - self.moved(end, kept, 0.5)
        return Flow(
            self.fields.at_corners(kept, self.tracing.faces),
            kept,
            confidence,
            self._rms(before),
            self._rms(left),
            float(self.masses[confidence < 0.5].sum() / self.area),
        )

    def standing(self, start: np.ndarray, end: np.ndarray) -> Flow:
        """No flow at all: what is advected along it is a cross-fade."""
        residual = self._rms(start - end)
        field = np.zeros((self.count, 2))
        return Flow(
            self.fields.at_corners(field, self.tracing.faces), field, np.zeros(self.count), residual, residual, 1.0
        )

    def _rms(self, difference: np.ndarray) -> float:
        return float(np.sqrt((self.masses @ (difference**2).mean(axis=1)) / self.area))

    def moved(self, signal: np.ndarray, field: np.ndarray, time: float) -> np.ndarray:
        """The signal (n, d) found at the end of the streamline of ``time`` (negative: upstream) from every vertex."""
        if not field.any():
            return signal
        corners = self.fields.at_corners(field, self.tracing.faces)
        faces, weights = self.paths(corners, time, LEVEL_STEPS)
        return np.einsum("pi,pid->pd", weights[-1], signal[self.tracing.faces[faces[-1]]])

    def paths(self, corners: np.ndarray, time: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
        """Where the streamlines of ``time`` of a field at corners (m, 3, 2) lead from every vertex, in equal steps.

        Returns faces (steps, n) int32 and barycentric weights (steps, n, 3).
        """
        best = np.full(self.count, -np.inf)
        face, corner = np.zeros(self.count, np.int32), np.zeros(self.count, np.int32)
        _native.leave_vertices(
            *self.tracing.tables, self.tracing.faces, np.ascontiguousarray(corners), np.sign(time), self.count, best,
            face, corner,
        )  # fmt: skip
        return self.tracing.streamlines(corners, face, np.eye(3)[corner], time, steps)

    def _correction(self, first: np.ndarray, second: np.ndarray, weight: float, tolerance: float) -> np.ndarray:
        """The smooth field that best explains first - second (n, d) to first order, scaled as P eq. 8 has it."""
        count = len(self.tracing.faces)
        data, right = weight * self._smooth.data, np.zeros(2 * self.count)
        tensors, pulls = np.empty((count, 3)), np.empty((count, 2))
        first, second = np.ascontiguousarray(first), np.ascontiguousarray(second)
        _native.assemble_flow(
            count, self.count, first.shape[1], len(data), self.tracing.faces, self._gradients, self.tracing.areas,
            self._spread, first, second, self._slot, data, right, tensors, pulls,
        )  # fmt: skip
        matrix = sp.csr_matrix((data, self._smooth.indices, self._smooth.indptr), shape=self._smooth.shape)
        coarse = TwoLevel(matrix, self._vector_clusters)
        answer = conjugate_gradients(matrix, right, tolerance=tolerance, precondition=coarse)
        x, y = np.einsum("fdi,fi->df", self._spread, answer[self._dofs])
        areas = self.tracing.areas
        gain = float((areas * (pulls[:, 0] * x + pulls[:, 1] * y)).sum())
        cost = float((areas * (tensors[:, 0] * x * x + 2 * tensors[:, 1] * x * y + tensors[:, 2] * y * y)).sum())
        scale = min(max(gain / cost, 0.0), 2.0) if cost > 0 else 0.0
        return scale * answer.reshape(-1, 2)

    def _confidence(self, before: np.ndarray, after: np.ndarray, field: np.ndarray, noise: float) -> np.ndarray:
        """1 where the flow explains the change; falls smoothly to 0 where it does not.

        It does not where much is left that is hardly less than without flow, or where the field squeezes or tears the
        texture (its derivative nears 1) to make the signals meet.
        """
        floor = noise**2
        left, was = (
            np.maximum(self.smooth((d**2).mean(axis=1)[:, None], 1e-4 * self.area, 1e-3)[:, 0], 0)
            for d in (after, before)
        )
        ratio = (left + floor) / (was + floor)
        unexplained = _smoothstep((ratio - 0.8) / 0.4) * _smoothstep((left / floor - 1) / 3)
        faces, areas = self.tracing.faces, self.tracing.areas
        derivative = np.einsum("fia,fib->fab", self.fields.at_corners(field, faces), self._gradients)
        stretch = np.sqrt((derivative**2).sum(axis=(1, 2))) * areas / 3
        mean = np.bincount(faces.ravel(), np.repeat(stretch, 3), minlength=self.count) / self.masses
        torn = _smoothstep((mean - 0.5) / 0.5)
        doubt = 1 - (1 - unexplained) * (1 - torn)
        return self.smooth((1 - doubt)[:, None], 3e-5 * self.area, 1e-3)[:, 0].clip(0, 1)


def _smoothstep(x: np.ndarray) -> np.ndarray:
    x = x.clip(0, 1)
    return x * x * (3 - 2 * x)


def _scalar_stiffness(tracing: TracingSurface, count: int) -> sp.csr_matrix:
    weight = half_cotangents(tracing).ravel()
    a, b = tracing.faces[:, [1, 2, 0]].ravel(), tracing.faces[:, [2, 0, 1]].ravel()
    rows, columns = np.concatenate([a, b, a, b]), np.concatenate([b, a, a, b])
    values = np.concatenate([-weight, -weight, weight, weight])
    return sp.coo_matrix((values, (rows, columns)), shape=(count, count)).tocsr()
