"""A walk as a sequence of OBJ + MTL + image, and walk.json beside it."""

import errno
import os
import re
import shutil
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future, wait
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.obj_writer import write_obj
from unstructured_mg.errors import UserError
from unstructured_mg.playback.stream import EncodedImage, PosedFrame
from unstructured_mg.playback.walk import Walk
from unstructured_mg.playback.walk_json import walk_text, walk_to_json
from unstructured_mg.playback.world import export_space

Progress = Callable[[int, int], None]
OUR_FILES = re.compile(r"walk\.json|frame_\d{5,}(_\d+)?\.\w+")
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
    with whole_folder(out, force) as folder:
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


@contextmanager
def whole_folder(out: Path, force: bool) -> Iterator[Path]:
    """A folder beside ``out`` that becomes ``out`` when the block ends well, and vanishes when it does not.

    Raises UserError where ``out`` is a file or a folder with something in it (with ``force``: with something in it that
    is not an earlier export's), and for what the operating system refuses.
    """
    out = Path(os.path.abspath(out))
    partial = out.with_name(f".{out.name}.{os.getpid()}.partial")
    try:
        _check_free(out, force)
        partial.parent.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir()
        yield partial
        _check_free(out, force)  # it may have been filled meanwhile
        if out.exists():
            replaced = out.with_name(f".{out.name}.{os.getpid()}.replaced")
            out.rename(replaced)
            partial.rename(out)
            shutil.rmtree(replaced)
        else:
            partial.rename(out)
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            fault, remedy = (
                "the disk is full, and nothing was kept",
                "free some space or choose a folder on another disk",
            )
        else:
            at = "" if error.filename is None or str(partial) in str(error.filename) else f" at {error.filename}"
            fault = f"the export failed{at} ({error.strerror or error}), and nothing was kept"
            remedy = "see to that or choose another folder"
        raise UserError(f"{out}: {fault}: {remedy}.") from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def _check_free(out: Path, force: bool) -> None:
    if not out.exists():
        return
    if not out.is_dir():
        raise UserError(f"{out}: this is a file, not a folder: choose another name.")
    names = sorted(path.name for path in out.iterdir())
    foreign = [name for name in names if not OUR_FILES.fullmatch(name)]
    if names and not force:
        raise UserError(
            f"{out}: the folder is not empty: choose another one, or replace an earlier export with --force."
        )
    if foreign:
        raise UserError(f"{out}: the folder holds {foreign[0]}, which no export wrote: choose another folder.")


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
