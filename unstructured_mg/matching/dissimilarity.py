"""How alike any two windows are, and at which yaw (P section 4, A.1)."""

from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft

from unstructured_mg import _native
from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.progress import Progress
from unstructured_mg.matching.descriptors import DESCRIPTORS
from unstructured_mg.matching.fields import Fields
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.matching.tasks import run
from unstructured_mg.matching.velocity import root_velocities
from unstructured_mg.matching.window import window_weights, windowed_means

# Windows along a tile's side: its series take 75 MB at N = 64, its halo of 2 k frames costs a tenth of the products.
TILE = 384
# Windows of a tile whose series are transformed at once: a few MB.
CHUNK = 4096


@dataclass(frozen=True)
class Dissimilarity:
    """Dissimilarities of all pairs of windows, the same way round as a matrix.

    Attributes
    ----------
    scores : (n, n) float32, symmetric: root mean square distance, in metres, between the surfaces of the window about
        frame s and those of the window about frame t, turned by the best yaw; NaN where either frame has no whole
        window
    yaw : (n, n) float32, radians in (-pi, pi], antisymmetric: turns the window of t (column) about +z onto that of s
        (row); NaN alike
    k : (n, n) int16, symmetric: frames either side of the centres of the windows compared; 0 where there are none
    size : metres: the actor's size, the median over frames of the larger of height and width
    """

    scores: np.ndarray
    yaw: np.ndarray
    k: np.ndarray
    size: float


def compute_dissimilarity(
    capture: Capture,
    options: MatchingOptions,
    *,
    scratch: Path,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Dissimilarity:
    """Dissimilarities of all windows of a capture.

    d_st^2 = min over yaw of sum_l w_l d_{s+l,t+l}(yaw) + tau^2 |v_s - R(yaw) v_t|^2, with d_st(yaw) of
    ``descriptors.py``, window weights w of P A.1 and the velocity term of ``velocity.py``. All three are linear in
    Fourier coefficients over the yaw: for every frequency the products of all frames are one matrix product, the
    window is a sum along its diagonals, and the inverse transform comes last, so that one yaw serves the whole
    window. The least of the 2 N yaws is then refined on the series by Newton's method.

    Files of about 2 MB a frame (N = 64) lie in ``scratch`` meanwhile. The result does not depend on the number of
    workers.
    """
    n, descriptor = len(capture), DESCRIPTORS[options.descriptor]
    centres = capture.window_centres(options.k)
    if not centres.any():
        nothing = np.full((n, n), np.nan, np.float32)
        return Dissimilarity(nothing, nothing.copy(), np.zeros((n, n), np.int16), 0.0)
    tell = progress or (lambda done, total: None)
    frequencies, cells, angles = descriptor.shape(options.resolution)
    fields = Fields(scratch, n, frequencies, cells)
    scratch.mkdir(parents=True, exist_ok=True)

    extents = []
    tasks = [(capture, options.descriptor, block) for block in fields.blocks()]
    for block, part in zip(fields.blocks(), run(_extents, tasks, executor), strict=True):
        extents.append(part)
        tell(block.stop, 3 * n)
    extent = np.concatenate(extents)
    layout = descriptor.fit(extent, options.resolution)
    try:
        own = []
        work = [(capture, options.descriptor, layout, fields, b, extent[b.start : b.stop]) for b in fields.blocks()]
        for block, part in zip(fields.blocks(), run(_describe, work, executor), strict=True):
            own.append(part)
            tell(n + block.stop, 3 * n)
        offset = windowed_means(np.concatenate(own), options.k)
        velocity = options.velocity_seconds * root_velocities(extent[:, :2], options.k, capture.fps)
        scores, yaw = compare_windows(
            fields,
            angles,
            offset,
            velocity,
            options.k,
            executor=executor,
            progress=lambda done, total: tell(2 * n + n * done // total, 3 * n),
        )
    finally:
        fields.remove()
    missing = ~(centres[:, None] & centres)
    scores[missing] = yaw[missing] = np.nan
    size = np.median(np.maximum(extent[:, 4] - extent[:, 3], 2 * extent[:, 2]))
    return Dissimilarity(scores, yaw, np.where(missing, 0, options.k).astype(np.int16), float(size))


def _extents(capture: Capture, descriptor: str, block: range) -> np.ndarray:
    return np.stack([DESCRIPTORS[descriptor].extent(capture.read(index)) for index in block])


def _describe(
    capture: Capture, descriptor: str, layout: Any, fields: Fields, block: range, extents: np.ndarray
) -> np.ndarray:
    """Write the coefficients of one block of frames; returns the frames' scores against themselves."""
    own = np.zeros(len(block))
    stacked = np.empty((2, fields.frequencies, len(block), fields.cells), np.complex64)
    for position, index in enumerate(block):
        left, right, own[position] = DESCRIPTORS[descriptor].describe(capture.read(index), extents[position], layout)
        stacked[0, :, position], stacked[1, :, position] = left, right
    fields.write(block, stacked)
    return own


def compare_windows(
    fields: Fields,
    angles: int,
    offset: np.ndarray,
    velocity: np.ndarray,
    k: int,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Scores and yaws ``(frames, frames) float32`` as in Dissimilarity, but NaN only within k of the first and last
    frame.

    ``fields`` are the frames' coefficients over ``angles`` yaws; ``offset`` (frames,) the windows' scores against
    themselves, in square metres, and ``velocity`` (frames,) complex, the windows' root velocities times tau, in
    metres.
    """
    n = fields.frames
    scores, yaw = np.full((n, n), np.nan, np.float32), np.full((n, n), np.nan, np.float32)
    sides = [range(start, min(start + TILE, n - k)) for start in range(k, n - k, TILE)]
    tiles = [(rows, columns) for i, rows in enumerate(sides) for columns in sides[i:]]
    tasks = [(fields, angles, rows, columns, offset, velocity, k) for rows, columns in tiles]
    for done, ((a, b), tile) in enumerate(zip(tiles, run(_tile, tasks, executor), strict=True), 1):
        rows, columns = slice(a.start, a.stop), slice(b.start, b.stop)
        scores[rows, columns], yaw[rows, columns] = tile
        if progress is not None:
            progress(done, len(tiles))
    # One value for a pair and its mirror image, also inside the tiles on the diagonal.
    lower = np.tril_indices(n, -1)
    scores[lower], yaw[lower] = scores.T[lower], -yaw.T[lower]
    np.fill_diagonal(scores, 0)
    np.fill_diagonal(yaw, 0)
    return scores, yaw


def _tile(
    fields: Fields,
    angles: int,
    rows: range,
    columns: range,
    offset: np.ndarray,
    velocity: np.ndarray,
    k: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Scores and yaws ``(len(rows), len(columns)) float32`` of one tile of windows."""
    shape = (len(rows), len(columns))
    # With the inverse transform's 1 / angles and the form's 1 / 2: what is summed below is c_0 + 2 Re sum_m c_m e^(i
    # m yaw).
    weights = (window_weights(k) / (2 * angles)).astype(np.float32)
    series = np.empty((fields.frequencies, *shape), np.complex64)
    for frequency in range(fields.frequencies):
        left, right = (fields.read(field, frequency, rows.start - k, rows.stop + k) for field in (0, 1))
        if columns == rows:
            products = left @ right.T
            products = products + products.conj().T
        else:
            other_left, other_right = (
                fields.read(field, frequency, columns.start - k, columns.stop + k) for field in (0, 1)
            )
            products = left @ other_right.T
            products += (other_left @ right.T).conj().T
        _native.window_diagonals(products.view(np.float32), weights, series[frequency].view(np.float32), *shape)
    across, along = velocity[rows.start : rows.stop, None], velocity[columns.start : columns.stop]
    series[0] -= (offset[rows.start : rows.stop, None] + offset[columns.start : columns.stop]) / 2
    series[0] += np.abs(across) ** 2 + np.abs(along) ** 2
    series[1] -= across.conj() * along

    flat = series.reshape(fields.frequencies, -1)
    least, yaw = np.empty(flat.shape[1]), np.empty(flat.shape[1])
    for start in range(0, flat.shape[1], CHUNK):
        chunk = slice(start, start + CHUNK)
        coarse = np.argmin(scipy.fft.irfft(flat[:, chunk], n=angles, axis=0), axis=0)
        yaw[chunk] = coarse * (2 * np.pi / angles)
        series_by_pair = np.ascontiguousarray(flat[:, chunk].T).view(np.float32)
        _native.refine_yaw(series_by_pair, yaw[chunk], least[chunk], fields.frequencies, np.pi / angles)
    yaw = np.pi - (np.pi - yaw) % (2 * np.pi)
    scores = np.sqrt(np.maximum(least, 0))
    return scores.reshape(shape).astype(np.float32), yaw.reshape(shape).astype(np.float32)
