"""The smallest capture that goes the whole road: a body that sways, and how to build it in two seconds."""

from pathlib import Path

import numpy as np
from broken_captures import BODY_VERTICES, write_frame

from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.pipeline.options import BuildOptions
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.texture_options import TextureOptions
from unstructured_mg.tracking.options import TrackingOptions

PERIOD = 10
TEXTURING = TextureOptions(texture_size=32, edge_length=0.1, levels=2)
TINY = BuildOptions(
    matching=MatchingOptions(k=2, resolution=16, minimum_gap_seconds=0.2, separation_seconds=0.15),
    tracking=TrackingOptions(cage_vertices=60),
    # Hollow and coarse as it is, it would not pass as an actor: here only the road counts.
    synthesis=SynthesisOptions(
        texture="crossfade",
        texturing=TEXTURING,
        surface_jump=100,
        velocity_jump=100,
        colour_jump=100,
        self_intersections=1,
        foot_slide=1,
        sharpness=0,
    ),
    max_pairs=1,
)


def write_tiny_capture(folder: Path, frames: int = 24) -> Path:
    """Two periods and a bit of swaying, so that windows a period apart are alike."""
    x, y, z = BODY_VERTICES.T
    for number in range(frames):
        bend = 0.25 * np.sin(2 * np.pi * number / PERIOD) * (y / 1.7) ** 2
        write_frame(folder, number, vertices=np.stack([x + bend, y, z + 0.001 * number * y], axis=1))
    return folder
