"""SCVV: a JSON manifest, a Draco mesh and a JPEG a frame."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.capture.draco import decode_draco
from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.manifest import file_in, read_manifest
from unstructured_mg.capture.paths import read_regular_file
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.stretch import file_stamp
from unstructured_mg.capture.texture import Texture

_REMEDY = "mend the manifest, or export the capture again"


@dataclass(frozen=True)
class Scvv:
    """Mesh and texture ("" where there is none) of every frame, as the manifest names them, and the rate."""

    frames: tuple[tuple[str, str], ...]
    fps: float | None


def is_scvv(data: dict[str, Any]) -> bool:
    frames = data.get("frames")
    return isinstance(frames, list) and bool(frames) and isinstance(frames[0], dict) and "mesh_path" in frames[0]


def open_scvv(path: Path) -> Scvv:
    """The frames that the manifest lists. Raises FrameError where one of them names no mesh."""
    return _open(path, file_stamp(path))


@lru_cache(maxsize=8)
def _open(path: Path, stamp: tuple[int, int]) -> Scvv:
    data = read_manifest(path)
    frames = []
    for number, item in enumerate(data["frames"]):
        mesh = item.get("mesh_path") if isinstance(item, dict) else None
        texture = item.get("texture_path", "") if isinstance(item, dict) else ""
        if not isinstance(mesh, str) or not isinstance(texture, str):
            raise FrameError(path, f"frames[{number}]: expected mesh_path and texture_path", _REMEDY)
        frames.append((mesh, texture))
    try:
        fps = float(data.get("average_fps", 0))
    except (TypeError, ValueError):
        fps = 0.0
    return Scvv(tuple(frames), fps if 0 < fps <= 1000 else None)


def read_scvv(path: Path, folder: Path, part: int) -> RawMesh:
    """Frame ``part``. Raises FrameError as ``open_scvv``, ``decode_draco``, and where a file is not there."""
    frames = open_scvv(path).frames
    if part >= len(frames):
        raise FrameError(path, f"it has no frame {part} any more", "inspect the capture again")
    mesh_name, texture_name = frames[part]
    file = file_in(path, folder, mesh_name, "mesh")
    mesh = decode_draco(file, 0, read_regular_file(file))
    texture = Texture(file_in(path, folder, texture_name, "texture")) if texture_name else None
    colors = None
    if mesh.colors >= 0:
        values = mesh.attributes[mesh.colors][:, :3]
        colors = (
            values.astype(np.uint8)
            if values.dtype.kind in "iu"
            else np.rint(255 * np.clip(values, 0, 1)).astype(np.uint8)
        )
    return RawMesh(
        vertices=mesh.vertices,
        faces=mesh.faces,
        uv=np.zeros((0, 2)) if mesh.uv < 0 else mesh.attributes[mesh.uv].astype(np.float64),
        face_uv=np.full_like(mesh.faces, -1) if mesh.uv < 0 else mesh.faces.copy(),
        colors=colors,
        images=() if texture is None else (texture,),
        face_image=np.full(len(mesh.faces), -1 if texture is None else 0, np.int32),
        files=(file,) if texture is None else (file, texture.path),
    )
