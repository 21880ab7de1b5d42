"""Writing the procedural capture as a real one comes: a folder of OBJ, MTL and JPEG, metres, y up."""

import json
from concurrent.futures import Executor
from dataclasses import asdict
from pathlib import Path

import numpy as np
from PIL import Image

from unstructured_mg.capture.obj_writer import write_obj
from unstructured_mg.capture.procedural.figure import ProceduralCapture
from unstructured_mg.capture.procedural.motion import FPS
from unstructured_mg.capture.progress import Progress

BATCH = 10  # frames a task: enough that starting it costs nothing beside it


def write_procedural(
    folder: Path,
    *,
    frames: int = 300,
    faces: int = 8000,
    texture_size: int = 512,
    seed: int = 0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> None:
    """Write ``frame_0000.obj``, ``.mtl`` and ``.jpg`` and so on into ``folder``, in metres, y up, floor at y = 0.

    ``capture.json`` beside them gives fps, unit, up axis and floor, and the actions with their first and last frames.
    The same arguments give the same bytes for any ``executor``. ``progress`` is told (frames done, frames).
    Raises ValueError for a figure out of range (see ProceduralCapture).
    """
    capture = ProceduralCapture(frames, faces, texture_size, seed)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    facts = {
        "fps": FPS,
        "unit": "m",
        "up": "y",
        "floor": 0.0,
        "actions": [asdict(action) for action in capture.actions],
    }
    (folder / "capture.json").write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
    batches = [range(first, min(first + BATCH, frames)) for first in range(0, frames, BATCH)]
    run = map if executor is None else executor.map
    done = 0
    for count in run(_write_batch, [folder] * len(batches), [capture] * len(batches), batches):
        done += count
        if progress is not None:
            progress(done, frames)


def _write_batch(folder: Path, capture: ProceduralCapture, batch: range) -> int:
    for frame in batch:
        mesh = capture.frame_mesh(frame)
        stem = f"frame_{frame:04d}"
        Image.fromarray(mesh.pixels).save(folder / f"{stem}.jpg", quality=92, subsampling=0)
        x, y, z = mesh.vertices.T
        write_obj(folder / f"{stem}.obj", np.stack([x, z, -y], 1), mesh.faces, mesh.uv, mesh.face_uv, (f"{stem}.jpg",))
    return len(batch)
