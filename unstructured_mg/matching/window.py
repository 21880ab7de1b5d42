"""The weights of a window's frames (P A.1)."""

import numpy as np
from scipy.interpolate import BSpline


def window_weights(k: int) -> np.ndarray:
    """``(2 k + 1,) float64`` summing to 1: the fifth-order B-spline that ends one frame outside the window."""
    spline = BSpline.basis_element(np.linspace(-1, 1, 7) * (k + 1), extrapolate=False)
    weights = spline(np.arange(-k, k + 1.0))
    return weights / weights.sum()


def windowed_means(values: np.ndarray, k: int) -> np.ndarray:
    """``(n,)``: weighted mean of ``values`` (n,) over the window about each frame; NaN within k of the ends."""
    means = np.full(len(values), np.nan, values.dtype)
    if len(values) > 2 * k:
        means[k : len(values) - k] = np.convolve(values, window_weights(k), mode="valid")
    return means
