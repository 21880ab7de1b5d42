"""Placing a synthesized shape, part by part (P section 6.5)."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from unstructured_mg.geometry.rotations import fit_rigid


def parts_of(stiffness: sp.spmatrix) -> np.ndarray:
    """Part ``(n,) int32`` of every vertex: those that a stiffness matrix couples, directly or not, move as one."""
    pattern = sp.csr_matrix(stiffness)
    pattern.eliminate_zeros()
    return connected_components(pattern, directed=False)[1].astype(np.int32)


def pose_parts(new: np.ndarray, between: np.ndarray, masses: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Move each part of ``new`` (n, 3) rigidly onto ``between``, the linear blend of the two frames.

    For every part the rotation R and shift o minimise (1-l) sum m |R p + o - p^s|^2 + l sum m |R p + o - p^t|^2
    (P section 6.5); up to a constant that is sum m |R p + o - ((1-l) p^s + l p^t)|^2, one rigid fit.
    A part without mass takes the linear blend.
    """
    posed = between.copy()
    order = np.argsort(parts, kind="stable")
    for members in np.split(order, np.flatnonzero(np.diff(parts[order])) + 1):
        if masses[members].sum() > 0:
            rotation, shift = fit_rigid(new[members], between[members], masses[members])
            posed[members] = new[members] @ rotation.T + shift
    return posed
