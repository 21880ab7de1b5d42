"""Transitions as arcs over the captured timeline (P Fig. 11)."""

from collections.abc import Sequence
from html import escape

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.playback.colormap import hex_color
from unstructured_mg.playback.frame_axis import frame_axis
from unstructured_mg.playback.report_data import TransitionEntry
from unstructured_mg.playback.svg import at, figure, label, number

WIDTH, SIDE = 1000.0, 16.0
# Height of the longest arc, and of the shortest.
HIGH, LOW = 190.0, 22.0


def plot_timeline(capture: Capture, covered: np.ndarray | None, transitions: Sequence[TransitionEntry]) -> str:
    """An ``svg`` element: ways forward in time above the frames, ways back below, coloured by cost.

    Each arc goes from the captured frame that the transition leaves (s - k) to the one that it reaches (t + k), and
    links to the pair. Frames of the graph are drawn strong; transitions that the graph does not play are dashed.

    Parameters
    ----------
    capture : for clips, gaps and frame ids
    covered : (n,) bool, frames in the graph; None draws all alike
    transitions : the arcs
    """
    axis = frame_axis(capture, SIDE, WIDTH - SIDE)
    ways = [(entry, axis.x[entry.leaves], axis.x[entry.arrives]) for entry in transitions]
    longest = max((abs(end - start) for _, start, end in ways), default=1.0)
    above = max((_height(end - start, longest) for _, start, end in ways if end > start), default=0.0)
    below = max((_height(end - start, longest) for _, start, end in ways if end <= start), default=0.0)
    ground = above + 16
    costs = [entry.cost for entry in transitions]
    lowest, highest = (min(costs), max(costs)) if costs else (0.0, 0.0)
    colors = {(e.source, e.target): color for e, color in zip(transitions, cost_colors(costs), strict=True)}

    parts = []
    # Long arcs first, so that short ones lie on top of them and can be pointed at.
    for entry, start, end in sorted(ways, key=lambda way: (-abs(way[2] - way[1]), way[0].source, way[0].target)):
        height = _height(end - start, longest) * (1 if end > start else -1)
        color = colors[entry.source, entry.target]
        top = at(ground - 4 / 3 * height)
        path = f"M{at(start)} {at(ground)}C{at(start)} {top} {at(end)} {top} {at(end)} {at(ground)}"
        source, target = axis.ids[entry.leaves], axis.ids[entry.arrives]
        text = (
            f"frame {source} to frame {target}, through {axis.ids[entry.source]} and {axis.ids[entry.target]}, "
            f"cost {number(entry.cost)}{'' if entry.in_graph else ', outside the graph'}"
        )
        first, second = sorted((entry.source, entry.target))
        kind = "arc" if entry.in_graph else "arc unused"
        parts.append(
            f'<a href="#pair-{first}-{second}"><title>{escape(text)}</title><path class="reach" d="{path}"/>'
            f'<path class="{kind}" style="--cost:{color}" d="{path}"/></a>'
        )
    for run in axis.runs:
        parts.append(_bar(axis.x[run.start], axis.x[run.stop - 1], axis.pitch, ground, "frames"))
    if covered is not None:
        edges = np.flatnonzero(np.diff(np.concatenate([[False], covered, [False]]).astype(np.int8)))
        starts = {run.start for run in axis.runs}
        for first, stop in zip(edges[::2], edges[1::2], strict=True):
            cuts = [first, *(cut for cut in range(first + 1, stop) if cut in starts), stop]
            for a, b in zip(cuts, cuts[1:], strict=False):
                parts.append(_bar(axis.x[a], axis.x[b - 1], axis.pitch, ground, "frames inside"))
    # The ticks stand below the arcs that go back.
    base = ground + below + 12
    parts += axis.draw(base)
    height = base + (44 if len(axis.clips) > 1 else 26)
    parts += _legend(height + 12, lowest, highest) if costs else []
    return figure(WIDTH, height + (34 if costs else 0), "Transitions over the captured frames", parts)


def _height(span: float, longest: float) -> float:
    return LOW + (HIGH - LOW) * float(np.sqrt(abs(span) / max(longest, 1e-9)))


def cost_colors(costs: Sequence[float]) -> list[str]:
    """``#rrggbb`` of each transition, from the lowest cost to the highest."""
    lowest, highest = min(costs, default=0.0), max(costs, default=0.0)
    return [_color((cost - lowest) / (highest - lowest) if highest > lowest else 0.0) for cost in costs]


def _color(share: float) -> str:
    # The colour map's ends would vanish on a dark or a light page.
    return hex_color(0.28 + 0.5 * share)


def _bar(first: float, last: float, pitch: float, y: float, kind: str) -> str:
    width = max(last - first + pitch, 1.5)
    return f'<rect class="{kind}" x="{at(first - pitch / 2)}" y="{at(y - 4)}" width="{at(width)}" height="8" rx="2"/>'


def _legend(y: float, lowest: float, highest: float) -> list[str]:
    cells = 24
    parts = [
        f'<rect class="cell" style="--cost:{_color(cell / (cells - 1))}" x="{at(SIDE + 6 * cell)}" y="{at(y)}" '
        f'width="6.3" height="10"/>'
        for cell in range(cells)
    ]
    text = f"cost {number(lowest)} to {number(highest)}"
    return [*parts, label(SIDE + 6 * cells + 10, y + 9, text, "tick", "start")]
