"""A walk as a sequence of OBJ + MTL + image, and walk.json beside it."""

from collections import deque
from collections.abc import Iterable, Mapping
from concurrent.futures import Executor, Future, wait
from pathlib import Path

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.obj_writer import write_obj
from unstructured_mg.capture.progress import Progress
from unstructured_mg.playback.stream import EncodedImage, PosedFrame
from unstructured_mg.playback.walk import Walk
from unstructured_mg.playback.walk_json import walk_text, walk_to_json
from unstructured_mg.playback.whole_folder import whole_folder
from unstructured_mg.playback.world import export_space

OUR_FILES = r"walk\.json|frame_\d{5,}(_\d+)?\.\w+"
WAITING = 16  # frames that may be on their way to the workers: enough to keep them busy, few enough to hold in memory


def export_obj(
    frames: Iterable[PosedFrame],
    capture: Capture,
    walk: Walk,
    out: Path,
    *,
    up: str | None = None,
    unit: float | None = None,
    force: bool = False,
    inputs: Mapping[str, str] | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> None:
    """Write ``frame_00001.obj``, ``.mtl`` and its image, ..., and ``walk.json`` into a new folder ``out``.

    A frame of several materials has images ``frame_00001_1``, ``frame_00001_2``, ... Images are the stored bytes,
    untouched. The folder appears when it is complete: all is written into a folder beside it, which is then renamed.

    Parameters
    ----------
    frames : the walk's frames, as ``posed_frames(walk, ...)`` yields them
    up, unit : the export's axis and metres per unit; the capture's own where not given
    force : replace ``out`` where it holds an earlier export
    inputs : what the walk was made from, for walk.json
    executor : where given, frames are written by its workers

    Raises
    ------
    UserError
        Where ``out`` is taken or cannot be written; nothing is left behind.
    ValueError
        Where ``frames`` are not as many as the walk has.
    """
    space = export_space(capture, up, unit)
    width = max(5, len(str(len(walk))))
    with whole_folder(out, OUR_FILES, force) as folder:
        written: list[str] = []
        waiting: deque[Future[None]] = deque()
        try:
            for number, frame in enumerate(frames, start=1):
                stem = f"frame_{number:0{width}d}"
                arrays = (space.points(frame.vertices), frame.faces, frame.uv, frame.face_uv)
                job = (folder / f"{stem}.obj", *arrays, frame.textures, frame.face_material, frame.colors)
                written.append(f"{stem}.obj")
                if executor is None:
                    _write_frame(*job)
                else:
                    waiting.append(executor.submit(_write_frame, *job))
                    if len(waiting) > WAITING:
                        waiting.popleft().result()
                if progress is not None:
                    progress(len(written) - len(waiting), len(walk))
            while waiting:
                waiting.popleft().result()
                if progress is not None:
                    progress(len(written) - len(waiting), len(walk))
        finally:  # a worker that still writes would put files back into a folder that is being removed
            for future in waiting:
                future.cancel()
            wait(waiting)
        if len(written) != len(walk):
            raise ValueError(f"frames: expected the walk's {len(walk)}, got {len(written)}")
        text = walk_text(walk_to_json(walk, capture, space, written, inputs))
        (folder / "walk.json").write_text(text, encoding="utf-8")


def _write_frame(
    path: Path,
    vertices: np.ndarray,
    faces: np.ndarray,
    uv: np.ndarray,
    face_uv: np.ndarray,
    textures: tuple[EncodedImage, ...],
    face_material: np.ndarray | None,
    colors: np.ndarray | None,
) -> None:
    images = []
    for index, texture in enumerate(textures, start=1):
        ending = texture.suffix if len(textures) == 1 else f"_{index}{texture.suffix}"
        images.append(path.stem + ending)
        path.with_name(images[-1]).write_bytes(texture.data)
    write_obj(path, vertices, faces, uv, face_uv, tuple(images), face_material, colors)
