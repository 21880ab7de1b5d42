"""UVOL 2: a JSON manifest, a Draco or GLB mesh a frame, and KTX2 textures of several frames each."""

import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.capture.draco import decode_draco
from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.gltf_reader import read_gltf
from unstructured_mg.capture.manifest import file_in, positive, read_manifest
from unstructured_mg.capture.paths import read_regular_file
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.stretch import file_stamp
from unstructured_mg.capture.texture import Texture

_ENDINGS = {"draco": ".drc", "glb": ".glb", "ktx2": ".ktx2"}
_MOST_FRAMES = 1 << 20
_REMEDY = "mend the manifest, or export the capture again"


@dataclass(frozen=True)
class _Target:
    name: str
    format: str
    fps: float
    count: int
    files: int  # of frames in one file
    pixels: float
    scale: float


@dataclass(frozen=True)
class Uvol:
    """The geometry that is read, and the texture, and where their files are (as the manifest's templates have it)."""

    geometry: _Target
    geometry_path: str
    texture: _Target | None
    texture_path: str


def is_uvol(data: dict[str, Any]) -> bool:
    return "geometry" in data and ("version" in data or "texture" in data)


def is_uvol_1(data: dict[str, Any]) -> bool:
    return "frameData" in data and ("maxVertices" in data or "maxTriangles" in data)


def open_uvol(path: Path) -> Uvol:
    """Of the manifest's targets the finest that can be read: for geometry Draco or GLB with the highest rate, for the
    texture KTX2 (of the base colour) with the most pixels.

    Raises FrameError where the manifest is not of version 2, lacks something, or offers nothing that can be read.
    """
    return _open(path, file_stamp(path))


@lru_cache(maxsize=8)
def _open(path: Path, stamp: tuple[int, int]) -> Uvol:
    data = read_manifest(path)
    if data.get("version") not in ("v2", 2, "2"):
        raise FrameError(path, f'expected version "v2", found {data.get("version")!r}', "convert it to UVOL 2")
    geometry = data["geometry"]
    if not isinstance(geometry, dict) or not isinstance(geometry.get("path"), str):
        raise FrameError(path, "expected geometry with targets and a path", _REMEDY)
    shapes = _targets(path, geometry.get("targets"), "geometry", "frameCount")
    readable = [target for target in shapes if target.format in ("draco", "glb")]
    if not readable:
        offered = ", ".join(sorted({target.format for target in shapes})) or "nothing"
        raise FrameError(path, f"its geometry is {offered}", "encode it as Draco or GLB")
    best = max(readable, key=lambda target: (target.fps, target.count, target.format == "draco", target.name))
    texture = data.get("texture")
    pictures: list[_Target] = []
    if isinstance(texture, dict):
        nested = texture.get("baseColor")
        listed = nested.get("targets") if isinstance(nested, dict) else texture.get("targets")
        if not isinstance(texture.get("path"), str):
            raise FrameError(path, "expected a path for the texture", _REMEDY)
        offers = _targets(path, listed, "texture", "sequenceCount")
        pictures = [target for target in offers if target.format == "ktx2"]
        if offers and not pictures:
            raise FrameError(
                path, f"its texture is {', '.join(sorted({target.format for target in offers}))}", "encode it as KTX2"
            )
    finest = max(pictures, key=lambda target: (target.pixels, target.fps, target.name), default=None)
    return Uvol(
        best, geometry["path"], finest, texture["path"] if finest is not None and isinstance(texture, dict) else ""
    )


def read_uvol(path: Path, folder: Path, part: int) -> RawMesh:
    """Frame ``part``, v turned upwards. Raises FrameError as ``open_uvol`` and as the readers of its files."""
    uvol = open_uvol(path)
    target = uvol.geometry
    file = file_in(path, folder, _expand(uvol.geometry_path, target, part, path), "geometry")
    if target.format == "glb":
        raw = read_gltf(file, folder)
        vertices, faces, uv, face_uv, files = raw.vertices, raw.faces, raw.uv, raw.face_uv, raw.files
    else:
        data = read_regular_file(file)
        mesh = decode_draco(file, 0, data)
        vertices, faces, files = mesh.vertices, mesh.faces, (file,)
        if mesh.uv < 0:
            uv, face_uv = np.zeros((0, 2)), np.full_like(faces, -1)
        else:
            uv, face_uv = mesh.attributes[mesh.uv].astype(np.float64) * [1, -1] + [0, 1], faces.copy()
    texture = None
    if uvol.texture is not None:
        picture = round(part * uvol.texture.fps / target.fps)
        picture = min(picture, uvol.texture.count * uvol.texture.files - 1) if uvol.texture.count else picture
        name = _expand(uvol.texture_path, uvol.texture, picture // uvol.texture.files, path)
        texture = Texture(file_in(path, folder, name, "texture"), coding="basis", layer=picture % uvol.texture.files)
        files = (*files, texture.path)
    return RawMesh(
        vertices=vertices * target.scale,
        faces=faces,
        uv=uv,
        face_uv=face_uv,
        images=() if texture is None else (texture,),
        face_image=np.full(len(faces), -1 if texture is None else 0, np.int32),
        files=files,
    )


def _expand(template: str, target: _Target, index: int, path: Path) -> str:
    """A path template with its ``[...]`` filled in."""
    filled = {"[target]": target.name, "[type]": "baseColor", "[tag]": "default", "[ext]": _ENDINGS[target.format]}
    for key, value in filled.items():
        template = template.replace(key, value)
    expanded, found = re.subn(r"\[(#+)\]", lambda match: f"{index:0{len(match[1])}d}", template)
    if found == 0:
        raise FrameError(path, f'expected [####] in the path "{template}"', _REMEDY)
    return expanded


def _targets(path: Path, listed: Any, what: str, count_key: str) -> list[_Target]:
    if not isinstance(listed, dict):
        raise FrameError(path, f"expected targets of the {what}", _REMEDY)
    targets = []
    for name, item in listed.items():
        kind = item.get("format") if isinstance(item, dict) else None
        if not isinstance(kind, str):
            raise FrameError(path, f'expected a format for the {what} "{name}"', _REMEDY)
        if item.get("type") not in (None, "baseColor"):
            continue
        settings = item.get("settings") if isinstance(item.get("settings"), dict) else {}
        size = item.get("resolution", settings.get("resolution"))
        if isinstance(size, dict):
            size = [size.get("width"), size.get("height")]
        pixels = 0.0
        if isinstance(size, list) and len(size) == 2:
            pixels = np.prod([positive(path, value, f'the resolution of "{name}"', 65536) for value in size]).item()
        count = item.get(count_key, item.get("frameCount", 0))
        if what == "geometry" or count:
            count = positive(path, count, f'{count_key} of "{name}"', _MOST_FRAMES)
        targets.append(
            _Target(
                str(name),
                kind,
                positive(path, item.get("frameRate"), f'frameRate of "{name}"', 1000),
                int(count),
                int(positive(path, item.get("sequenceSize", 1), f'sequenceSize of "{name}"', 1 << 16)),
                pixels,
                positive(path, item.get("scale", 1), f'scale of "{name}"', 1e6),
            )
        )
    return targets
