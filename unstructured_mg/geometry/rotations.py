"""Nearest rotations: the local step of as-rigid-as-possible energies, and Horn's absolute orientation."""

import numpy as np

from unstructured_mg import _native
from unstructured_mg.geometry.planar import PlanarRigid


def fit_rotations(matrices: np.ndarray) -> np.ndarray:
    """Proper rotations nearest to ``matrices`` (c, 3, 3) float64: each maximises tr(R^T A) over SO(3)."""
    matrices = np.ascontiguousarray(matrices, dtype=np.float64)
    if matrices.ndim != 3 or matrices.shape[1:] != (3, 3):
        raise ValueError(f"matrices: expected shape (c, 3, 3), got {matrices.shape}")
    if not np.isfinite(matrices).all():
        raise ValueError("matrices: expected finite entries, got NaN or infinity")
    rotations = np.empty_like(matrices)
    _native.fit_rotations(matrices, rotations)
    return rotations


def fit_rigid(source: np.ndarray, target: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation R (3, 3) and translation o (3,) minimising sum_i w_i |R p_i + o - q_i|^2 (Horn et al. 1988).

    ``source`` p and ``target`` q are (n, 3) float64, ``weights`` w (n,) not all zero.
    """
    total = weights.sum()
    if not total > 0:
        raise ValueError("weights: expected a positive sum")
    p0, q0 = weights @ source / total, weights @ target / total
    covariance = (target - q0).T @ (weights[:, None] * (source - p0))
    rotation = fit_rotations(covariance[None])[0]
    return rotation, q0 - rotation @ p0


def fit_planar(source: np.ndarray, target: np.ndarray, weights: np.ndarray) -> PlanarRigid:
    """The floor-plane motion minimising sum_i w_i |R p_i + o - q_i|^2 over yaw and 2-D shift (P section 6.1)."""
    total = weights.sum()
    if not total > 0:
        raise ValueError("weights: expected a positive sum")
    p, q = source[:, :2], target[:, :2]
    p0, q0 = weights @ p / total, weights @ q / total
    covariance = (q - q0).T @ (weights[:, None] * (p - p0))
    yaw = np.arctan2(covariance[1, 0] - covariance[0, 1], covariance[0, 0] + covariance[1, 1])
    c, s = np.cos(yaw), np.sin(yaw)
    return PlanarRigid(float(yaw), float(q0[0] - c * p0[0] + s * p0[1]), float(q0[1] - s * p0[0] - c * p0[1]))
