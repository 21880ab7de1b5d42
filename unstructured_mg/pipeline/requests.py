"""What the command line asks of a path, and the files that say it."""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.graph.request import PathRequest
from unstructured_mg.pipeline.store import user_errors

Entry = TypeVar("Entry")


def path_request(
    capture: Capture,
    *,
    start: str | None,
    goal: str | None,
    frames: int | None,
    seconds: float | None,
    distance: float | None,
    curve: Path | None,
    poses: Path | None,
    loop: bool,
    within: float | None,
) -> PathRequest:
    """The request that ``umg path``'s words mean for this capture."""
    if frames is not None and seconds is not None:
        raise UserError("--frames and --seconds do not go together: give one of them.")
    if seconds is not None:
        frames = max(1, round(seconds * capture.fps))
    return PathRequest(
        start=None if start is None else capture.index_of(start),
        goal=None if goal is None else capture.index_of(goal),
        frames=frames,
        distance=distance,
        curve=None if curve is None else read_curve(curve),
        poses=None if poses is None else read_poses(poses, capture),
        loop=loop,
        within=within,
    )


def read_curve(path: Path) -> np.ndarray:
    """(c, 2) float64: a line for each point of the floor, x and y in metres, with blanks or a comma between."""

    def point(words: list[str]) -> tuple[float, float]:
        x, y = (float(word) for word in words)
        if not np.isfinite(x) or not np.isfinite(y):
            raise ValueError
        return x, y

    points = _lines(path, point, "a point is two numbers, x and y in metres")
    if len(points) < 2:
        raise UserError(f"{path}: holds {len(points)} points; a curve takes two or more.")
    return np.array(points)


def read_poses(path: Path, capture: Capture) -> tuple[tuple[float, int], ...]:
    """(seconds, frame index), a line for each: seconds and a frame's id, in the order of time."""

    def pose(words: list[str]) -> tuple[float, int]:
        seconds, frame = words
        if not 0 <= float(seconds) < float("inf"):
            raise ValueError
        return float(seconds), capture.index_of(frame)

    found = _lines(path, pose, "a pose is its time in seconds and a frame's id")
    if len(found) < 2:
        raise UserError(f"{path}: holds {len(found)} poses; give two or more.")
    times = [seconds for seconds, _ in found]
    late = next((i for i in range(1, len(times)) if times[i] < times[i - 1]), None)
    if late is not None:
        raise UserError(
            f"{path}: {times[late]:g} seconds come after {times[late - 1]:g}; put the poses in order of time."
        )
    return tuple(found)


def _lines(path: Path, read: Callable[[list[str]], Entry], rule: str) -> list[Entry]:
    """Every line that is not empty; what follows a # is left out."""
    with user_errors(path):
        text = path.read_text(encoding="utf-8", errors="replace")
    entries = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split("#", 1)[0].replace(",", " ").split()
        if words:
            try:
                entries.append(read(words))
            except ValueError:
                raise UserError(f'{path}, line {number}: "{line.strip()}" is no good: {rule}.') from None
    return entries
