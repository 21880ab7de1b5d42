"""Signals at the flow surface's vertices from the texels of an image; holes filled over the surface."""

import numpy as np
import scipy.sparse as sp

from unstructured_mg.geometry.conjugate import conjugate_gradients
from unstructured_mg.synthesis.flow_surface import FlowSurface
from unstructured_mg.synthesis.texels import Texels


def vertex_signals(
    surface: FlowSurface, texels: Texels, colors: np.ndarray, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Hat-weighted means (n, c) of texel colours (t, c) around every vertex (P A.4, preprocess).

    ``known`` (t,) bool says which texels count. Also returns (n,) bool: vertices with any such texel.
    """
    count = len(surface.vertices)
    chosen = np.flatnonzero(known & texels.inside)
    corner = surface.tracing.faces[texels.face[chosen]]
    second, third = texels.weights[chosen].T.astype(np.float64)
    sums, total = np.zeros((count, colors.shape[1])), np.zeros(count)
    values = colors[chosen].astype(np.float64)
    for i, weight in enumerate((1 - second - third, second, third)):
        total += np.bincount(corner[:, i], weight, minlength=count)
        for c in range(colors.shape[1]):
            sums[:, c] += np.bincount(corner[:, i], weight * values[:, c], minlength=count)
    has = total > 1e-9
    return np.divide(sums, total[:, None], out=np.zeros_like(sums), where=has[:, None]), has


def fill_harmonic(stiffness: sp.csr_matrix, masses: np.ndarray, signals: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Extend signals (n, c) from known vertices (n,) bool over the others with least Dirichlet energy.

    Parts without a known vertex take the mean colour of the known ones.
    """
    if known.all():
        return signals
    if not known.any():
        return np.full_like(signals, 127.5)
    free, held = np.flatnonzero(~known), np.flatnonzero(known)
    mean = signals[held].mean(axis=0)
    # A trace of mass pulls parts that touch nothing known to the mean and leaves the others as they are.
    anchor = sp.diags(1e-9 * stiffness.diagonal()[free].mean() * (masses[free] / max(masses.mean(), 1e-300) + 1))
    matrix = (stiffness[free][:, free] + anchor).tocsr()
    offsets = signals[held] - mean
    filled = signals.copy()
    filled[free] = mean + conjugate_gradients(matrix, -(stiffness[free][:, held] @ offsets), tolerance=1e-6)
    return filled
