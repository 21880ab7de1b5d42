"""Packed descriptions by few numbers a frequency, for captures too long for whole ones.

The bilinear form of ``correlation.py`` multiplies a rough field X with a smooth one E, and the E of all frames of a
capture lie near a space of few dimensions: with an orthonormal basis V of that space, <X, E> is nearly
<X V, E V>. X may be as rough as it likes. Disk and products shrink from the number of cells to the rank.
"""

import numpy as np


def learn_basis(described: np.ndarray, rank: int) -> np.ndarray:
    """``(frequencies, cells, rank) complex64``: the principal directions of E, from packed descriptions of sample
    frames (frames, 2 frequencies, cells). Fewer than ``rank`` where there are fewer frames.
    """
    frequencies = described.shape[1] // 2
    return np.stack(
        [
            np.linalg.svd(described[:, frequencies + m], full_matrices=False)[2][:rank].conj().T
            for m in range(frequencies)
        ]
    )


def project(described: np.ndarray, basis: np.ndarray) -> tuple[np.ndarray, float]:
    """A packed description (2 frequencies, cells) in a basis: (2 frequencies, rank), and the score against itself."""
    frequencies = len(basis)
    left = np.einsum("fc,fcr->fr", described[:frequencies], basis.conj(), optimize=True)
    right = np.einsum("fc,fcr->fr", described[frequencies:], basis, optimize=True)
    own = np.einsum("fr,fr->f", left, right).real
    return np.concatenate([left, right]), float(own[0] + 2 * own[1:].sum()) / (2 * frequencies)


def largest_error(described: np.ndarray, basis: np.ndarray) -> float:
    """By how much scores of pairs of the described frames (frames, 2 frequencies, cells), each at its best of
    2 frequencies yaws, are wrong in a basis at most; for frames that the basis was not learnt from.
    """
    reduced = np.stack([project(each, basis)[0] for each in described])
    whole, approximate = (_frame_scores(values) for values in (described, reduced))
    return float(np.abs(whole - approximate).max())


def _frame_scores(described: np.ndarray) -> np.ndarray:
    """``(frames, frames)``: scores of single frames, by the definition in ``correlation.py``."""
    left, right = np.split(described, 2, axis=1)
    products = np.einsum("sfc,tfc->stf", left, right, optimize=True)
    series = (products + products.conj().swapaxes(0, 1)) / 2
    curves = np.fft.irfft(series, n=described.shape[1], axis=2)
    own = np.einsum("ssy->sy", curves)[:, 0]
    return np.sqrt(np.maximum((curves - (own[:, None, None] + own[:, None]) / 2).min(axis=2), 0))
