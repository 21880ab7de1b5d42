"""Where every captured frame stands on the floor, measured once and kept in the work folder."""

import json
from typing import Any

import numpy as np

from unstructured_mg.capture.capture import Capture, frame_hash
from unstructured_mg.geometry.centre import floor_centre
from unstructured_mg.pipeline.cluster import ClusterPool
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.store import Store
from unstructured_mg.pipeline.timings import Timings

VERSION = 1
# Frames that a worker reads at a time.
BLOCK = 16


def captured_places(
    store: Store, pool: Pool | ClusterPool, capture: Capture, progress: StageProgress, timings: Timings
) -> np.ndarray:
    """(n, 2) float64 metres: the floor centre of every captured frame, in its captured place."""
    inputs: dict[str, Any] = {
        "stage": "places",
        "stage_version": VERSION,
        "frames": [frame_hash(capture, index) for index in range(len(capture))],
        "unit": capture.unit,
        "up": capture.up,
        "floor": capture.floor,
    }
    if store.find("places.json", inputs) is None:
        blocks = [range(first, min(first + BLOCK, len(capture))) for first in range(0, len(capture), BLOCK)]
        with progress.stage("places on the floor") as advance, timings.wall("places"):
            found: list[list[float]] = []
            for part in pool.executor.map(_centres, [capture] * len(blocks), blocks):
                found += part
                advance(len(found), len(capture))
        store.commit_json("places.json", inputs, found)
    return np.array(json.loads(store.path("places.json").read_text()), np.float64).reshape(-1, 2)


def _centres(capture: Capture, block: range) -> list[list[float]]:
    meshes = (capture.read(index) for index in block)
    return [floor_centre(mesh.vertices, mesh.faces).tolist() for mesh in meshes]
