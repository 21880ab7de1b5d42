"""The weights of a window's frames (P A.1, H equation 4), and which lengths of windows there are."""

import numpy as np
from scipy.interpolate import BSpline

# How many lengths adaptive windows are tried in, the smallest and the largest among them.
LENGTHS = 5


def spline_weights(k: int) -> np.ndarray:
    """``(2 k + 1,) float64`` summing to 1: the fifth-order B-spline that ends one frame outside the window (P A.1)."""
    spline = BSpline.basis_element(np.linspace(-1, 1, 7) * (k + 1), extrapolate=False)
    weights = spline(np.arange(-k, k + 1.0))
    return weights / weights.sum()


def triangle_weights(k: int) -> np.ndarray:
    """``(2 k + 1,) float64`` summing to 1, linear to both sides of the centre: w of H equation 4 for n = 2 k + 1."""
    weights = k + 1.0 - np.abs(np.arange(-k, k + 1))
    return weights / weights.sum()


def window_lengths(smallest: int, largest: int) -> tuple[int, ...]:
    """Up to LENGTHS half windows, evenly from ``smallest`` to ``largest``."""
    return tuple(np.unique(np.linspace(smallest, largest, LENGTHS).round().astype(int)).tolist())


def windowed_means(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """``(n,)``: mean of ``values`` (n,) by ``weights`` (2 k + 1,) about each frame; NaN within k of the ends."""
    means = np.full(len(values), np.nan, values.dtype)
    k = len(weights) // 2
    if len(values) > 2 * k:
        means[k : len(values) - k] = np.convolve(values, weights[::-1], mode="valid")
    return means
