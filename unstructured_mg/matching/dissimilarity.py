"""How alike any two windows are, and at which yaw (P section 4, A.1; H section 3; B section 3.1)."""

from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.progress import Progress
from unstructured_mg.errors import UserError
from unstructured_mg.matching.descriptor import Window
from unstructured_mg.matching.descriptors import DESCRIPTORS
from unstructured_mg.matching.extent import actor_size, extent
from unstructured_mg.matching.face_colours import has_colours
from unstructured_mg.matching.fields import Fields
from unstructured_mg.matching.low_rank import largest_error, learn_basis, project
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.matching.tasks import run
from unstructured_mg.matching.velocity import root_velocities
from unstructured_mg.matching.window import spline_weights, triangle_weights, window_lengths

# Windows along a tile's side: the series of one length of windows take 75 MB at N = 64, its halo of 2 k frames costs a
# tenth of the products. With several lengths tiles are half as wide.
TILE = 384
# Frames that tell a basis's error.
HELD_OUT = 24


@dataclass(frozen=True)
class Dissimilarity:
    """Dissimilarities of all pairs of windows, the same way round as a matrix.

    Attributes
    ----------
    scores : (n, n) float32, symmetric: how far apart the window about frame s and that about frame t, turned by the
        best yaw, are: the root mean square over their frames, in the descriptor's unit; NaN where either frame has no
        whole window
    yaw : (n, n) float32, radians in (-pi, pi], antisymmetric: turns the window of t (column) about +z onto that of s
        (row); NaN alike
    k : (n, n) int16, symmetric: frames either side of the centres of the windows compared; 0 where there are none
    size : metres: the actor's size, the median over frames of the larger of height and width
    unit : of the scores: "m", "rad", or "" for a pure number
    rank_error : with a ``rank``, the largest error of a score between sample frames that the basis was not learnt from,
        in that unit; None where scores are exact
    """

    scores: np.ndarray
    yaw: np.ndarray
    k: np.ndarray
    size: float
    unit: str
    rank_error: float | None = None


@dataclass(frozen=True)
class Described:
    """All frames of a capture as one descriptor sees them; small and picklable, the bulk is in ``fields``.

    ``own`` (n,): the frames' scores against themselves. ``roots`` (n, 2) metres; ``size`` metres. ``rank_error`` as in
    Dissimilarity.
    """

    descriptor: str
    fields: Fields
    layout: Any
    own: np.ndarray
    roots: np.ndarray
    size: float
    rank_error: float | None = None


def compute_dissimilarity(
    capture: Capture,
    options: MatchingOptions,
    *,
    scratch: Path,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Dissimilarity:
    """Dissimilarities of all windows of a capture.

    score^2 = min over yaw of sum_l w_l d_{s+l,t+l}(yaw)^2 + tau^2 |v_s - R(yaw) v_t|^2, with the descriptor's distance
    d of two frames, window weights w and the velocity term of ``velocity.py``: one yaw serves the whole window.

    Fixed windows have P's weights. Adaptive ones have H's (equation 4) and, for each pair, the length with the least
    score (equation 5) among a few from ``k`` to ``largest_k``; without a smallest one, the shortest would nearly
    always win. H takes each frame pair's own best yaw and a mean of distances in place of their squares. Longer
    windows than the smallest are not looked at where they would overlap.

    About 2 MB a frame (N = 64) lie in ``scratch`` meanwhile, or 1 kB for each number of a ``rank``. The result does not
    depend on the number of workers.
    """
    n, descriptor = len(capture), DESCRIPTORS[options.descriptor]
    if not capture.window_centres(options.k).any():
        nothing = np.full((n, n), np.nan, np.float32)
        return Dissimilarity(nothing, nothing.copy(), np.zeros((n, n), np.int16), 0.0, descriptor.unit)
    tell = progress or (lambda done, total: None)
    described = describe_frames(
        capture,
        options,
        scratch=scratch,
        executor=executor,
        progress=lambda done, total: tell(2 * n * done // total, 3 * n),
    )
    try:
        return compare_windows(
            capture,
            described,
            options,
            executor=executor,
            progress=lambda done, total: tell(2 * n + n * done // total, 3 * n),
        )
    finally:
        described.fields.remove()


def describe_frames(
    capture: Capture,
    options: MatchingOptions,
    *,
    scratch: Path,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Described:
    """Describe all frames, with what is bulky in files in ``scratch``; whoever asks for it removes ``fields``.

    A UserError where a frame cannot be described, or where colours are to count and there are none.
    """
    n, descriptor = len(capture), DESCRIPTORS[options.descriptor]
    tell = progress or (lambda done, total: None)
    if options.colour_m and not has_colours(capture.read(0)):
        raise UserError(f"{capture.folder}: the capture has no colours; leave out --colour.")
    blocks = Fields(scratch, n, 0, 0, np.float32).blocks()
    extents = []
    for block, part in zip(blocks, run(_extents, [(capture, block) for block in blocks], executor), strict=True):
        extents.append(part)
        tell(block.stop, 2 * n)
    extent = np.concatenate(extents)
    layout = descriptor.fit(capture, extent, options.resolution or descriptor.resolution, options.colour_m)
    rows, cells, dtype = descriptor.shape(layout)
    scratch.mkdir(parents=True, exist_ok=True)
    basis, error = None, None
    if options.rank is not None:
        basis = scratch / "basis.npy"
        cells, error = _learn(capture, options, layout, extent, basis, executor)
    fields = Fields(scratch, n, rows, cells, dtype)
    own = []
    work = [(capture, options.descriptor, layout, fields, b, extent[b.start : b.stop], basis) for b in blocks]
    try:
        for block, part in zip(blocks, run(_describe, work, executor), strict=True):
            own.append(part)
            tell(n + block.stop, 2 * n)
    except BaseException:
        fields.remove()
        raise
    finally:
        if basis is not None:
            basis.unlink(missing_ok=True)
    roots, size = extent[:, :2], actor_size(extent)
    return Described(options.descriptor, fields, layout, np.concatenate(own), roots, size, error)


def _learn(
    capture: Capture,
    options: MatchingOptions,
    layout: Any,
    extents: np.ndarray,
    basis: Path,
    executor: Executor | None,
) -> tuple[int, float]:
    """Write a basis learnt from frames spread over the capture; returns its rank, and its error on frames between."""
    assert options.rank is not None
    n = len(capture)
    learnt = np.unique(np.linspace(0, n - 1, min(n, 2 * options.rank)).astype(int))
    others = np.setdiff1d(np.arange(n), learnt)
    held = others[np.unique(np.linspace(0, len(others) - 1, HELD_OUT).astype(int))] if len(others) else learnt
    tasks = [(capture, options.descriptor, layout, int(i), extents[i]) for i in (*learnt, *held)]
    described = np.stack(list(run(_describe_one, tasks, executor)))
    vectors = learn_basis(described[: len(learnt)], options.rank)
    np.save(basis, vectors)
    return vectors.shape[2], largest_error(described[len(learnt) :], vectors)


def _describe_one(capture: Capture, descriptor: str, layout: Any, index: int, extent: np.ndarray) -> np.ndarray:
    return DESCRIPTORS[descriptor].describe(capture, index, extent, layout)[0]


def _extents(capture: Capture, block: range) -> np.ndarray:
    return np.stack([extent(capture.read(index)) for index in block])


def _describe(
    capture: Capture,
    descriptor: str,
    layout: Any,
    fields: Fields,
    block: range,
    extents: np.ndarray,
    basis: Path | None,
) -> np.ndarray:
    """Write what describes one block of frames; returns the frames' scores against themselves."""
    vectors = None if basis is None else np.load(basis)
    own = np.zeros(len(block))
    stacked: np.ndarray = np.empty((fields.rows, len(block), fields.cells), fields.dtype)
    for position, index in enumerate(block):
        values, own[position] = DESCRIPTORS[descriptor].describe(capture, index, extents[position], layout)
        if vectors is not None:
            values, own[position] = project(values, vectors)
        stacked[:, position] = values
    fields.write(block, stacked)
    return own


@dataclass(frozen=True)
class Lengths:
    """The windows to compare, shortest first, and for each of their lengths what may be its centre, (n,) bool.

    ``positions`` (n,): two windows share no frame where their centres' positions differ by 2 k + 1 or more.
    """

    windows: tuple[Window, ...]
    centres: tuple[np.ndarray, ...]
    positions: np.ndarray


def window_kinds(capture: Capture, described: Described, options: MatchingOptions) -> Lengths:
    """The windows that the options ask for."""
    adaptive = options.windows == "adaptive"
    weigh = triangle_weights if adaptive else spline_weights
    lengths = window_lengths(options.k, options.largest_k or 2 * options.k) if adaptive else (options.k,)
    descriptor = DESCRIPTORS[options.descriptor]
    scale = options.velocity_seconds
    if descriptor.unit != "m":
        scale *= descriptor.threshold / (DESCRIPTORS["cylindrical_edt"].threshold * described.size)
    windows, centres = [], []
    for k in lengths:
        inside = capture.window_centres(k)
        if inside.any():
            weights = weigh(k)
            velocity = scale * root_velocities(described.roots, weights, capture.fps)
            windows.append(Window(k, weights, np.where(np.isnan(velocity), 0, velocity)))
            centres.append(inside)
    clips = {name: index for index, name in enumerate(capture.clips)}
    far = 2 * (lengths[-1] + 1) + max(frame.number for frame in capture.frames)
    positions = np.array([clips[frame.clip] * far + frame.number for frame in capture.frames])
    return Lengths(tuple(windows), tuple(centres), positions)


def compare_windows(
    capture: Capture,
    described: Described,
    options: MatchingOptions,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Dissimilarity:
    """Dissimilarities of all windows of described frames."""
    n, lengths = len(capture), window_kinds(capture, described, options)
    scores, yaw = np.full((n, n), np.nan, np.float32), np.full((n, n), np.nan, np.float32)
    k = np.zeros((n, n), np.int16)
    least, side = lengths.windows[0].k, TILE if len(lengths.windows) == 1 else TILE // 2
    sides = [range(start, min(start + side, n - least)) for start in range(least, n - least, side)]
    tiles = [(rows, columns) for i, rows in enumerate(sides) for columns in sides[i:]]
    tasks = [(described, lengths, rows, columns) for rows, columns in tiles]
    for done, ((a, b), tile) in enumerate(zip(tiles, run(_tile, tasks, executor), strict=True), 1):
        rows, columns = slice(a.start, a.stop), slice(b.start, b.stop)
        scores[rows, columns], yaw[rows, columns], k[rows, columns] = tile
        if progress is not None:
            progress(done, len(tiles))
    # One value for a pair and its mirror image, also inside the tiles on the diagonal.
    for start in range(0, n, TILE):
        rows = slice(start, start + TILE)
        below = np.tri(len(scores[rows]), n, start - 1, dtype=bool)
        for matrix, sign in ((scores, 1), (yaw, -1), (k, 1)):
            matrix[rows][below] = sign * matrix[:, rows].T[below]
    alone = np.flatnonzero(lengths.centres[0])
    scores[alone, alone] = yaw[alone, alone] = 0
    unit = DESCRIPTORS[described.descriptor].unit
    return Dissimilarity(scores, yaw, k, described.size, unit, described.rank_error)


def _tile(
    described: Described, lengths: Lengths, rows: range, columns: range
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Scores and yaws float32 and half windows int16 of one tile of windows, (len(rows), len(columns))."""
    compare = DESCRIPTORS[described.descriptor].compare
    across, along = slice(rows.start, rows.stop), slice(columns.start, columns.stop)
    apart = np.abs(lengths.positions[across, None] - lengths.positions[along])
    shape = (len(rows), len(columns))
    best, yaw, k = np.full(shape, np.inf), np.full(shape, np.nan, np.float32), np.zeros(shape, np.int16)
    compared = compare(described.fields, described.layout, described.own, rows, columns, lengths.windows)
    for window, centres, (squares, yaws) in zip(lengths.windows, lengths.centres, compared, strict=True):
        allowed = centres[across, None] & centres[along]
        if window is not lengths.windows[0]:
            allowed &= apart >= 2 * window.k + 1
        better = allowed & (squares < best)
        best[better], yaw[better], k[better] = squares[better], yaws[better], window.k
    scores = np.where(np.isinf(best), np.nan, np.sqrt(np.maximum(best, 0)))
    return scores.astype(np.float32), yaw, k
