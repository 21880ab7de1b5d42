"""Captured frames along a line: clips apart, gaps open."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.playback.svg import label, line


@dataclass(frozen=True)
class FrameAxis:
    """Where each frame of a capture stands on a plot.

    Attributes
    ----------
    capture : whose frames they are
    x : (n,) float64 plot coordinates
    pitch : width of one frame
    runs : frames that follow each other without a gap
    clips : (name, first frame index, last frame index)
    ids : frame ids
    """

    capture: Capture

    x: np.ndarray
    pitch: float
    runs: tuple[range, ...]
    clips: tuple[tuple[str, int, int], ...]
    ids: tuple[str, ...]

    def draw(self, y: float) -> list[str]:
        """Ticks with frame numbers below ``y``, and the clips' names where there are several."""
        parts = []
        for index, number in frame_ticks(self.capture):
            parts.append(line(self.x[index], y, self.x[index], y + 5, "axis"))
            parts.append(label(self.x[index], y + 18, number))
        if len(self.clips) > 1:
            parts += [label((self.x[a] + self.x[b]) / 2, y + 36, name, "clip") for name, a, b in self.clips]
        return parts


def frame_ticks(capture: Capture, about: int = 14) -> list[tuple[int, str]]:
    """Frame indices to mark on an axis, with their numbers: round ones, or the first of a clip that has none."""
    step = _round_step(len(capture) / about)
    frames = capture.frames
    ticks = [(i, str(frame.number)) for i, frame in enumerate(frames) if frame.number % step == 0]
    marked = {frames[i].clip for i, _ in ticks}
    firsts = {frame.clip: i for i, frame in reversed(list(enumerate(frames)))}
    ticks += [(i, str(frames[i].number)) for clip, i in firsts.items() if clip not in marked]
    return sorted(ticks)


def frame_axis(capture: Capture, left: float, right: float) -> FrameAxis:
    """Lay the frames of a capture out between two plot coordinates."""
    runs = tuple(capture.runs())
    clip_of = [frame.clip for frame in capture.frames]
    position = np.zeros(len(capture))
    next_position = 0.0
    for run in runs:
        if run.start > 0:
            between_clips = clip_of[run.start] != clip_of[run.start - 1]
            next_position += max(0.03 * len(capture), 2.0) if between_clips else max(0.006 * len(capture), 1.0)
        position[run.start : run.stop] = next_position + np.arange(len(run))
        next_position += len(run)
    pitch = (right - left) / max(next_position, 1.0)
    clips = []
    for index, clip in enumerate(clip_of):
        if index == 0 or clip != clip_of[index - 1]:
            clips.append((clip, index, index))
        clips[-1] = (clip, clips[-1][1], index)
    ids = tuple(capture.frame_id(index) for index in range(len(capture)))
    return FrameAxis(capture, left + pitch * (position + 0.5), pitch, runs, tuple(clips), ids)


def _round_step(least: float) -> int:
    size = 1
    while True:
        for multiple in (1, 2, 5):
            if multiple * size >= least:
                return multiple * size
        size *= 10
