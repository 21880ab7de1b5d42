"""Posing the reference surface: dual-quaternion skinning (Kavan et al. 2007), which keeps volume at twisted joints."""

import numpy as np

from unstructured_mg.capture.procedural.skeleton import PARENT, REST


def quaternions(rotations: np.ndarray) -> np.ndarray:
    """Unit quaternions (..., 4), w first, of rotations (..., 3, 3)."""
    m = rotations
    table = np.empty(m.shape[:-2] + (4, 4))
    table[..., 0, 0] = m[..., 0, 0] + m[..., 1, 1] + m[..., 2, 2]
    table[..., 0, 1] = table[..., 1, 0] = m[..., 2, 1] - m[..., 1, 2]
    table[..., 0, 2] = table[..., 2, 0] = m[..., 0, 2] - m[..., 2, 0]
    table[..., 0, 3] = table[..., 3, 0] = m[..., 1, 0] - m[..., 0, 1]
    table[..., 1:, 1:] = m + np.swapaxes(m, -1, -2)
    trace = table[..., 0, 0].copy()
    for i in range(1, 4):
        table[..., i, i] -= trace
    return np.linalg.eigh(table)[1][..., -1]


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    w = a[..., 0] * b[..., 0] - np.sum(a[..., 1:] * b[..., 1:], -1)
    v = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([w[..., None], v], -1)


def pose(vertices: np.ndarray, weights: np.ndarray, rotations: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Posed (n, 3) vertices.

    Parameters
    ----------
    vertices : (n, 3) float64 at rest
    weights : (n, joints) float64, rows sum to 1
    rotations, positions : (joints, 3, 3) and (joints, 3) float64, rest to world
    """
    # Relative to the pelvis no joint turns by half a circle, so neighbours' signs can be chosen along the chain.
    base = rotations[0]
    real = quaternions(base.T @ rotations)
    for joint, parent in enumerate(PARENT):
        against = np.array([1.0, 0.0, 0.0, 0.0]) if parent < 0 else real[parent]
        if real[joint] @ against < 0:
            real[joint] = -real[joint]
    shift = (positions - positions[0]) @ base - np.einsum("jab,jb->ja", base.T @ rotations, REST)
    dual = 0.5 * _times(np.concatenate([np.zeros((len(shift), 1)), shift], 1), real)
    # Not by BLAS: its rounding may depend on the number of threads.
    blended = np.einsum("nj,jk->nk", weights, np.concatenate([real, dual], 1))
    length = np.linalg.norm(blended[:, :4], axis=1, keepdims=True)
    q, d = blended[:, :4] / length, blended[:, 4:] / length
    w, v = q[:, :1], q[:, 1:]
    turned = vertices + 2 * np.cross(v, np.cross(v, vertices) + w * vertices)
    moved = 2 * (w * d[:, 1:] - d[:, :1] * v + np.cross(v, d[:, 1:]))
    return np.einsum("ab,nb->na", base, turned + moved) + positions[0]
