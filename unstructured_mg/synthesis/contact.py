"""What stands on the floor in both windows of a pair."""

import numpy as np

# Metres above the floor within which a sole that keeps its place is planted.
SOLE_HEIGHT = 0.025
# Metres a frame below which a sole keeps its place.
SOLE_REST = 0.004


def planted(first: np.ndarray, second: np.ndarray, step: int) -> np.ndarray:
    """(n,) bool: what stands from ``step`` to the next in both windows ``(2k+1, n, 3)``.

    It is lower than SOLE_HEIGHT and moves less than SOLE_REST a frame along the floor.
    """
    standing = np.ones(first.shape[1], bool)
    for window in (first, second):
        standing &= (window[step, :, 2] < SOLE_HEIGHT) & (window[step + 1, :, 2] < SOLE_HEIGHT)
        standing &= np.linalg.norm(window[step + 1, :, :2] - window[step, :, :2], axis=1) < SOLE_REST
    return standing
