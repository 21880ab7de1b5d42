"""Windows of frames that are described by functions of the yaw, at the yaw at which they agree best.

A descriptor gives every frame two fields of Fourier coefficients over the yaw, X and E, such that two frames s, t, the
latter turned by yaw, differ by the bilinear form

    D_st(yaw) = 1/2 (<X_s, R(yaw) E_t> + <E_s, R(yaw) X_t>),   d_st = D_st - (D_ss(0) + D_tt(0)) / 2.

That covers a surface measure against squared distances (P A.1) and, with E = -2 X, |X_s - R X_t|^2. (P A.1 prints one
factor twice.) Windows come first and the minimum over yaw last: sum_l w_l d_{s+l,t+l}(yaw) is linear in the
coefficients, so for every frequency the products of all frames are one matrix product, the window is a sum along its
diagonals, and one inverse FFT gives all yaws. The least of them is refined on the series by Newton's method.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.fft

from unstructured_mg import _native
from unstructured_mg.matching.descriptor import Window
from unstructured_mg.matching.fields import Fields
from unstructured_mg.matching.window import windowed_means

# Windows whose series are transformed at once: a few MB.
CHUNK = 4096


def pack(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """``(angles, cells)``: the two fields X and E, (cells, angles) float32, as the rows of a frame's description.

    The frequency angles / 2 carries no direction and is left out: (angles / 2, cells) complex64 of X, then of the
    conjugate of E.
    """
    keep = left.shape[1] // 2
    spectra = [scipy.fft.rfft(field, axis=1)[:, :keep].T for field in (left, right)]
    return np.concatenate([spectra[0], spectra[1].conj()])


def compare(
    fields: Fields, layout: Any, own: np.ndarray, rows: range, columns: range, windows: Sequence[Window]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """``Descriptor.compare`` for frames described by ``pack``; the layout is not needed."""
    frequencies, angles, k = fields.rows // 2, fields.rows, max(window.k for window in windows)
    shape = (len(rows), len(columns))
    all_series = [np.empty((frequencies, *shape), np.complex64) for _ in windows]
    for frequency in range(frequencies):
        at = (frequency, frequencies + frequency)
        left, right = (fields.read(row, rows.start - k, rows.stop + k) for row in at)
        if columns == rows:
            products = left @ right.T
            products = products + products.conj().T
        else:
            other_left, other_right = (fields.read(row, columns.start - k, columns.stop + k) for row in at)
            products = left @ other_right.T
            products += (other_left @ right.T).conj().T
        for window, series in zip(windows, all_series, strict=True):
            # With the inverse transform's 1 / angles and the form's 1 / 2: what is summed below is c_0 + 2 Re sum_m c_m
            # e^(i m yaw).
            weights = (window.weights / (2 * angles)).astype(np.float32)
            inner = slice(k - window.k, window.k - k or None)
            values = np.ascontiguousarray(products[inner, inner]).view(np.float32)
            _native.window_diagonals(values, weights, series[frequency].view(np.float32), *shape)
    return [_best_yaws(series, own, rows, columns, window) for window, series in zip(windows, all_series, strict=True)]


def _best_yaws(
    series: np.ndarray, own: np.ndarray, rows: range, columns: range, window: Window
) -> tuple[np.ndarray, np.ndarray]:
    """Least values and yaws of the windowed series ``(frequencies, rows, columns)``, which are overwritten."""
    angles, offset = 2 * len(series), windowed_means(own, window.weights)
    across, along = window.velocity[rows.start : rows.stop, None], window.velocity[columns.start : columns.stop]
    series[0] -= (offset[rows.start : rows.stop, None] + offset[columns.start : columns.stop]) / 2
    series[0] += np.abs(across) ** 2 + np.abs(along) ** 2
    series[1] -= across.conj() * along

    flat = series.reshape(len(series), -1)
    least, yaw = np.empty(flat.shape[1]), np.empty(flat.shape[1])
    for start in range(0, flat.shape[1], CHUNK):
        chunk = slice(start, start + CHUNK)
        coarse = np.argmin(scipy.fft.irfft(flat[:, chunk], n=angles, axis=0), axis=0)
        yaw[chunk] = coarse * (2 * np.pi / angles)
        series_by_pair = np.ascontiguousarray(flat[:, chunk].T).view(np.float32)
        _native.refine_yaw(series_by_pair, yaw[chunk], least[chunk], len(series), np.pi / angles)
    yaw = np.pi - (np.pi - yaw) % (2 * np.pi)
    return least.reshape(series.shape[1:]), yaw.reshape(series.shape[1:])
