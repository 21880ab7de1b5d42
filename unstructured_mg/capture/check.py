"""Checking every frame of a capture: whether it can be used, what it is made of, where it stands."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from unstructured_mg.capture.capture import FrameFile
from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.frame_reader import read_frame
from unstructured_mg.capture.image import check_image
from unstructured_mg.capture.paths import read_regular_file
from unstructured_mg.capture.placement import FrameBounds, frame_bounds
from unstructured_mg.errors import FrameFault
from unstructured_mg.geometry.components import compact, face_components, significant_faces


@dataclass(frozen=True)
class CheckedFrame:
    """A good frame: its file with its hash, its bounds in capture units, and whether it has images or vertex
    colours.
    """

    file: FrameFile
    bounds: FrameBounds
    has_texture: bool
    has_colors: bool


def check_frames(files: list[FrameFile], folder: Path) -> list[CheckedFrame | FrameFault]:
    """Check frames one after another; a file that several share is hashed and decoded once."""
    digests: dict[Path, bytes] = {}
    return [_check_frame(file, folder, digests) for file in files]


def _check_frame(file: FrameFile, folder: Path, digests: dict[Path, bytes]) -> CheckedFrame | FrameFault:
    try:
        mesh, _, raw = read_frame(file.path, folder)
        whole = hashlib.sha256()
        for path in raw.files:
            if path not in digests:
                if path in raw.images:
                    check_image(path)
                digests[path] = hashlib.sha256(read_regular_file(path)).digest()
            whole.update(digests[path])
    except FrameError as error:
        return FrameFault(file.clip, file.number, str(error.file), error.fault, error.remedy)
    except MemoryError:
        return FrameFault(
            file.clip, file.number, str(file.path), "it needs more memory than there is", "export it smaller"
        )
    return CheckedFrame(
        replace(file, sha256=whole.hexdigest()),
        frame_bounds(_body(mesh.vertices, mesh.faces)),
        bool(mesh.textures),
        mesh.colors is not None,
    )


def _body(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The vertices of all components but debris: where the frame stands is read off these."""
    if not face_components(len(vertices), faces).any():
        return vertices
    return compact(vertices, faces[significant_faces(vertices, faces)])[0]
