"""The dissimilarity matrix with the pairs that were chosen in it."""

import io
from collections.abc import Sequence
from html import escape

import numpy as np
from PIL import Image

from unstructured_mg.capture.capture import Capture
from unstructured_mg.playback.colormap import COLORS, color_map
from unstructured_mg.playback.frame_axis import frame_ticks
from unstructured_mg.playback.report_data import PairOutcome
from unstructured_mg.playback.svg import apart, at, data_uri, figure, label, line, round_steps

# Plot units; the matrix picture has at most this many pixels a side.
SIDE, MARGIN, PIXELS = 640.0, 50.0, 900
MISSING = 255


def plot_matrix(
    capture: Capture, scores: np.ndarray, unit: str, threshold: float, gap: int, pairs: Sequence[PairOutcome]
) -> str:
    """An ``svg`` element: dark where two windows are alike, pairs in the upper right half.

    The colour follows the square root of the score, up to the 99th percentile of all scores, because the pairs of
    interest lie at the low end. In large matrices a pixel shows the least score of its block: no match vanishes.

    Parameters
    ----------
    capture : for frame ids and clips
    scores : (n, n) float, NaN where there is no window (grey)
    unit : of the scores: "m", "rad" or ""
    threshold : marked on the colour scale
    gap : frames; pairs nearer the diagonal than this were not considered
    pairs : kept ones are circles, refused ones crosses; each links to its place in the report
    """
    n = len(scores)
    finite = scores[np.isfinite(scores)]
    highest = float(np.quantile(finite, 0.99)) if finite.size else 1.0
    highest = highest if highest > 0 else 1.0
    cell = SIDE / n
    right, bottom = MARGIN + SIDE, 8 + SIDE

    def place(row: float, column: float) -> tuple[float, float]:
        return MARGIN + (column + 0.5) * cell, 8 + (row + 0.5) * cell

    parts = [
        f'<rect class="missing" x="{at(MARGIN)}" y="8" width="{at(SIDE)}" height="{at(SIDE)}"/>',
        f'<image x="{at(MARGIN)}" y="8" width="{at(SIDE)}" height="{at(SIDE)}" preserveAspectRatio="none" '
        f'style="image-rendering:{"pixelated" if n < 400 else "auto"}" '
        f'href="{data_uri(_png(scores, highest), "image/png")}"/>',
    ]
    if 0 < gap < n:
        (x1, y1), (x2, y2) = place(-0.5, gap - 0.5), place(n - gap - 0.5, n - 0.5)
        parts.append(line(x1, y1, x2, y2, "band"))
        parts.append(line(MARGIN + y1 - 8, 8 + x1 - MARGIN, MARGIN + y2 - 8, 8 + x2 - MARGIN, "band"))
    frames = capture.frames
    for index in range(1, n):
        if frames[index].clip != frames[index - 1].clip:
            x, y = place(index - 0.5, index - 0.5)
            parts += [line(x, 8, x, bottom, "cut"), line(MARGIN, y, right, y, "cut")]
    for index, text in frame_ticks(capture):
        x, y = place(index, index)
        parts += [line(x, bottom, x, bottom + 5, "axis"), label(x, bottom + 18, text)]
        parts += [line(MARGIN - 5, y, MARGIN, y, "axis"), label(MARGIN - 8, y + 4, text, "tick", "end")]
    clips = [frame.clip for frame in frames]
    if len(set(clips)) > 1:
        for clip in dict.fromkeys(clips):
            x, _ = place(0, (clips.index(clip) + n - 1 - clips[::-1].index(clip)) / 2)
            parts.append(label(x, bottom + 38, clip, "clip"))
    for pair in sorted(pairs, key=lambda pair: pair.status == "kept"):
        parts.append(_mark(capture, unit, pair, *place(pair.candidate.source, pair.candidate.target)))
    parts += _scale(right + 26, 8, SIDE, highest, threshold, unit)
    return figure(
        right + 118, bottom + (48 if len(set(clips)) > 1 else 28), "Dissimilarity of all pairs of frames", parts
    )


def _png(scores: np.ndarray, highest: float) -> bytes:
    blocks = -(-len(scores) // PIXELS)
    if blocks > 1:
        starts = np.arange(0, len(scores), blocks)
        scores = np.fmin.reduceat(np.fmin.reduceat(scores, starts, axis=0), starts, axis=1)
    missing = np.isnan(scores)
    share = np.sqrt(np.clip(np.where(missing, 0, scores) / highest, 0, 1))
    image = Image.fromarray(np.where(missing, MISSING, np.rint(254 * share)).astype(np.uint8), "P")
    palette = color_map(np.arange(256) / 254)
    image.putpalette(palette.tobytes())
    data = io.BytesIO()
    image.save(data, "PNG", optimize=True, transparency=MISSING)
    return data.getvalue()


def _mark(capture: Capture, unit: str, pair: PairOutcome, x: float, y: float) -> str:
    candidate = pair.candidate
    source, target = capture.frame_id(candidate.source), capture.frame_id(candidate.target)
    kept = pair.status == "kept"
    shape = (
        f'<circle class="kept" cx="{at(x)}" cy="{at(y)}" r="6"/>'
        if kept
        else f'<path class="refused" d="M{at(x - 4)} {at(y - 4)}l8 8m0-8l-8 8"/>'
    )
    text = (
        f"{source} and {target}: {apart(candidate.score, unit)} apart, {'kept' if kept else 'refused: ' + pair.reason}"
    )
    anchor = f"pair-{candidate.source}-{candidate.target}"
    reach = f'<circle class="reach" cx="{at(x)}" cy="{at(y)}" r="9"/>'
    return f'<a href="#{anchor}"><title>{escape(text)}</title>{reach}{shape}</a>'


def _scale(x: float, top: float, height: float, highest: float, threshold: float, unit: str) -> list[str]:
    """The colour bar, with the threshold on it."""
    stops = "".join(
        f'<stop offset="{at(i / 16)}" stop-color="#{bytes(COLORS[min(16 * i, 255)]).hex()}"/>' for i in range(17)
    )
    parts = [
        f'<defs><linearGradient id="scale" x1="0" y1="1" x2="0" y2="0">{stops}</linearGradient></defs>',
        f'<rect x="{at(x)}" y="{at(top)}" width="14" height="{at(height)}" fill="url(#scale)"/>',
    ]

    def level(value: float) -> float:
        return top + height * (1 - np.sqrt(min(value / highest, 1.0)))

    for value in round_steps(highest, 6):
        parts += [
            line(x + 14, level(value), x + 19, level(value), "axis"),
            label(x + 22, level(value) + 4, apart(value, unit) if value else "0", "tick", "start"),
        ]
    if 0 < threshold <= highest:
        y = level(threshold)
        parts.append(
            f'<path class="threshold" d="M{at(x - 9)} {at(y - 5)}l9 5l-9 5z">'
            f"<title>threshold {apart(threshold, unit)}</title></path>"
        )
        parts.append(line(x, y, x + 14, y, "limit"))
    return parts
