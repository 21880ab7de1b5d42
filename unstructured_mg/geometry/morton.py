"""An order in which neighbours in space are mostly neighbours in memory."""

import numpy as np

# Numbers 0..1023 with two zero bits between their own.
_SPREAD = sum((((np.arange(1024) >> bit) & 1) << (3 * bit) for bit in range(10)), start=np.zeros(1024, np.int64))


def morton_order(points: np.ndarray) -> np.ndarray:
    """Indices ``(n,) int64`` that sort points (n, 3) along a Morton curve, 1024 cells a side; ties keep their order."""
    low = points.min(axis=0)
    size = max(float((points.max(axis=0) - low).max()), 1e-300)
    cells = np.minimum((points - low) / size * 1024, 1023).astype(np.int64)
    x, y, z = cells.T
    return np.argsort(_SPREAD[x] | _SPREAD[y] << 1 | _SPREAD[z] << 2, kind="stable")
