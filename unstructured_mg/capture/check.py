"""Checking every frame of a capture: whether it can be used, what it is made of, where it stands."""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.frame_file import FrameFile
from unstructured_mg.capture.frame_reader import read_frame
from unstructured_mg.capture.placement import FrameBounds, frame_bounds
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.stretch import read_stretch, whole_digest
from unstructured_mg.capture.texture import Texture
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
    """Check frames one after another; what several share is hashed and decoded once."""
    checked: set[Texture] = set()
    return [_check_frame(file, folder, checked) for file in files]


def _check_frame(file: FrameFile, folder: Path, checked: set[Texture]) -> CheckedFrame | FrameFault:
    try:
        mesh, _, raw = read_frame(file, folder)
        for texture in raw.images:
            if texture not in checked:
                texture.check()
                checked.add(texture)
        sha256 = _digest(file, raw)
    except FrameError as error:
        return FrameFault(file.clip, file.number, str(error.file), error.fault, error.remedy)
    except MemoryError:
        return FrameFault(
            file.clip, file.number, str(file.path), "it needs more memory than there is", "export it smaller"
        )
    return CheckedFrame(
        replace(file, sha256=sha256),
        frame_bounds(_body(mesh.vertices, mesh.faces)),
        bool(mesh.textures),
        mesh.colors is not None,
    )


def _digest(file: FrameFile, raw: RawMesh) -> str:
    """SHA-256 over the bytes that the frame is made of, and, where they are not its own, over which of them it is."""
    whole = hashlib.sha256()
    if raw.stretches:
        for start, size in raw.stretches:
            whole.update(hashlib.sha256(read_stretch(raw.files[0], start, size, "a frame")).digest())
    for path in raw.files[1:] if raw.stretches else raw.files:
        whole.update(whole_digest(path))
    if file.part is not None:
        whole.update(f"{file.format} {file.part}".encode())
    return whole.hexdigest()


def _body(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The vertices of all components but debris: where the frame stands is read off these."""
    if not face_components(len(vertices), faces).any():
        return vertices
    return compact(vertices, faces[significant_faces(vertices, faces)])[0]
