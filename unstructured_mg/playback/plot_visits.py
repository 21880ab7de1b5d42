"""How often a long walk visits each captured frame, before and after choosing probabilities (P Fig. 10)."""

from collections.abc import Callable

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.playback.frame_axis import frame_axis
from unstructured_mg.playback.svg import at, figure, label, line, number, round_steps

WIDTH, HEIGHT, LEFT, SIDE, TOP = 1000.0, 210.0, 60.0, 16.0, 12.0


def plot_visits(capture: Capture, covered: np.ndarray, before: np.ndarray, after: np.ndarray) -> str:
    """An ``svg`` element: visits in multiples of the uniform share, which is the target.

    Parameters
    ----------
    capture : for clips, gaps and frame ids
    covered : (n,) bool, frames in the graph; the target is 1 / their number
    before, after : (n,) float64, shares of a walk's captured frames with uniform and with the chosen probabilities
    """
    axis = frame_axis(capture, LEFT, WIDTH - SIDE)
    frames = int(covered.sum())
    curves = {"before": before * frames, "after": after * frames}
    highest = 1.08 * max(1.0, *(float(curve.max(initial=0.0)) for curve in curves.values()))
    bottom = TOP + HEIGHT

    def level(value: float) -> float:
        return bottom - HEIGHT * value / highest

    parts = []
    for value in round_steps(highest, 4):
        parts += [line(LEFT, level(value), WIDTH - SIDE, level(value), "grid")]
        parts += [label(LEFT - 7, level(value) + 4, f"{number(value)} ×", "tick", "end")]
    for kind, curve in curves.items():
        path = "".join(_steps(axis.x, axis.pitch, run, curve, covered, level) for run in axis.runs)
        parts.append(f'<path class="visits {kind}" d="{path}"/>')
    parts.append(line(LEFT, level(1.0), WIDTH - SIDE, level(1.0), "target"))
    parts += axis.draw(bottom)
    return figure(WIDTH, bottom + (46 if len(axis.clips) > 1 else 28), "Visits of each captured frame", parts)


def _steps(
    x: np.ndarray,
    pitch: float,
    run: range,
    curve: np.ndarray,
    covered: np.ndarray,
    level: Callable[[float], float],
) -> str:
    """A stair with one tread a frame; equal neighbours share a tread, frames outside the graph have none."""
    heights = {index: at(level(curve[index])) for index in run if covered[index]}
    path = ""
    for index, height in heights.items():
        if index - 1 not in heights:
            path += f"M{at(x[index] - pitch / 2)} {height}"
        elif heights[index - 1] != height:
            path += f"V{height}"
        if heights.get(index + 1) != height:
            path += f"H{at(x[index] + pitch / 2)}"
    return path
