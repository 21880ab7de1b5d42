"""Conformance walks: seeds and the frames that every player must then show (docs/files.md)."""

from itertools import islice
from typing import Any

from unstructured_mg.capture.capture import Capture
from unstructured_mg.graph.motion_graph import MotionGraph
from unstructured_mg.playback.walk import WalkFrame, default_start, endless_walk

SEEDS = (0, 1, 42, 4294967295)
FRAMES = 500


def conformance_walks(graph: MotionGraph, capture: Capture, frames: int = FRAMES) -> dict[str, Any]:
    """Walks from the graph's first frame with four seeds, JSON-ready.

    Every frame is named as by `frame_label`.
    """
    start = default_start(graph, capture)
    return {
        "format": "unstructured_mg conformance walks",
        "version": 1,
        "generator": "sfc32",
        "start": capture.frame_id(start),
        "walks": [
            {
                "seed": seed,
                "frames": [frame_label(frame, capture) for frame in islice(endless_walk(graph, seed, start), frames)],
            }
            for seed in SEEDS
        ],
    }


def frame_label(frame: WalkFrame, capture: Capture) -> str:
    """``12`` for a captured frame, ``53>113:-9`` for step -9 of the transition through 53 and 113."""
    if frame.transition is None:
        assert frame.frame is not None
        return capture.frame_id(frame.frame)
    source, target = frame.transition
    return f"{capture.frame_id(source)}>{capture.frame_id(target)}:{frame.step}"
