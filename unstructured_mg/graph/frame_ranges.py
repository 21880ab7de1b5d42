"""Frames in words."""

from collections.abc import Sequence

import numpy as np

from unstructured_mg.capture.capture import Capture


def frame_ranges(frames: Sequence[int] | np.ndarray, capture: Capture, most: int = 8) -> str:
    """Ascending frame indices in words, "1 to 20, 31 and 40 to 90"; the middle is left out beyond ``most`` ranges."""
    breaks = np.flatnonzero(np.diff(frames) != 1) + 1
    run_starts = {run.start for run in capture.runs()}
    parts = []
    for piece in np.split(frames, breaks):
        begin = [i for i, frame in enumerate(piece) if i == 0 or int(frame) in run_starts]
        for first, stop in zip(begin, [*begin[1:], len(piece)], strict=True):
            a, b = capture.frame_id(int(piece[first])), capture.frame_id(int(piece[stop - 1]))
            parts.append(a if a == b else f"{a} to {b}")
    if len(parts) > most:
        parts = [*parts[: most // 2], "...", *parts[-(most // 2) :]]
    return parts[0] if len(parts) == 1 else ", ".join(parts[:-1]) + " and " + parts[-1]
