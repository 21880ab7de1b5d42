"""An order in which neighbours in space are mostly neighbours in memory."""

import numpy as np


def morton_order(points: np.ndarray) -> np.ndarray:
    """Indices ``(n,) int64`` that sort points (n, 3) along a Morton curve, 1024 cells a side; ties keep their order."""
    low = points.min(axis=0)
    size = max(float((points.max(axis=0) - low).max()), 1e-300)
    cells = np.minimum((points - low) / size * 1024, 1023).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(10):
        for axis in range(3):
            code |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")
