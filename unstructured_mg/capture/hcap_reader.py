"""glTF with the extension HCAP_holovideo: a mesh a frame, key frames and deltas to them, and a video."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.gltf_file import REMEDY, Gltf, open_gltf, read_accessor
from unstructured_mg.capture.paths import capture_roots, find_named
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.texture import Texture

NAME = "HCAP_holovideo"


@dataclass(frozen=True, eq=False)
class Holovideo:
    """The frames of the file: the attributes of each (accessors by name), the index of the key frame that each builds
    on, the rate and the video.
    """

    attributes: tuple[dict[str, Any], ...]
    keys: tuple[int, ...]
    fps: float | None
    video: Path | None


def open_hcap(path: Path, folder: Path) -> Holovideo | None:
    """The frames of a file with that extension, None where it has not got it. Raises FrameError as ``open_gltf``."""
    return _open(open_gltf(path, folder), folder)


@lru_cache(maxsize=4)
def _open(gltf: Gltf, folder: Path) -> Holovideo | None:
    extension = _extension(gltf.data)
    if extension is None:
        return None
    attributes, keys = [], []
    meshes = gltf.data.get("meshes")
    for index in range(len(meshes) if isinstance(meshes, list) else 0):
        primitives = gltf.item("meshes", index).get("primitives", [])
        own = _extension(primitives[0]) if isinstance(primitives, list) and primitives else None
        found = own.get("attributes") if own is not None else None
        if not isinstance(found, dict) or own is None or not {"POSITION", "_DELTA"} & set(found):
            raise FrameError(gltf.path, f"meshes[{index}]: expected POSITION or _DELTA in {NAME}", REMEDY)
        if "POSITION" in found:
            keys.append(index)
        elif not keys:
            raise FrameError(gltf.path, f"meshes[{index}]: expected a key frame before any delta", REMEDY)
        else:
            keys.append(keys[-1])
        attributes.append({**found, "indices": own.get("indices")})
    rate = extension.get("framerate")
    fps = float(rate) if isinstance(rate, (int, float)) and 0 < rate <= 1000 else None
    return Holovideo(tuple(attributes), tuple(keys), fps, _video(gltf, folder, extension))


def read_hcap(path: Path, folder: Path, part: int) -> RawMesh:
    """Frame ``part``. A key frame's positions stand in the range of its accessor; a delta frame adds its deltas to the
    positions of the frame before it, and, from the second one after a key frame on, what that frame had moved.

    Raises
    ------
    FrameError : as ``open_gltf``; also where the frame's arrays do not fit the key frame's
    """
    gltf = open_gltf(path, folder)
    holovideo = _open(gltf, folder)
    if holovideo is None or part >= len(holovideo.attributes):
        raise FrameError(path, f"it has no frame {part} any more", "inspect the capture again")
    key = holovideo.keys[part]
    start = holovideo.attributes[key]
    vertices = _ranged(gltf, start["POSITION"], 65535)
    velocity = np.zeros_like(vertices)
    for index in range(key + 1, part + 1):
        delta = _ranged(gltf, holovideo.attributes[index]["_DELTA"], 255)
        if delta.shape != vertices.shape:
            raise FrameError(path, f"meshes[{index}]: expected {len(vertices)} deltas, found {len(delta)}", REMEDY)
        velocity = velocity + delta
        vertices = vertices + velocity
    uv = read_accessor(gltf, start.get("TEXCOORD_0"), ("VEC2",))
    uv = uv.astype(np.float64) / (np.iinfo(uv.dtype).max if uv.dtype.kind == "u" else 1)
    corners = read_accessor(gltf, start["indices"], ("SCALAR",))
    if corners.dtype.kind != "u" or len(corners) % 3 or corners.max() >= len(vertices) or len(uv) != len(vertices):
        raise FrameError(path, f"meshes[{key}]: its indices and uvs do not fit its {len(vertices)} vertices", REMEDY)
    faces = corners.reshape(-1, 3).astype(np.int32)
    video = holovideo.video
    return RawMesh(
        vertices=vertices,
        faces=faces,
        uv=uv * [1, -1] + [0, 1],
        face_uv=faces.copy(),
        images=() if video is None else (Texture(video, coding="video", layer=part),),
        face_image=np.full(len(faces), -1 if video is None else 0, np.int32),
        files=gltf.files() if video is None else (*gltf.files(), video),
    )


def _ranged(gltf: Gltf, index: Any, most: int) -> np.ndarray:
    """Unsigned integers of 0 to ``most`` to where they stand between the accessor's decodeMin and decodeMax."""
    values = read_accessor(gltf, index, ("VEC3",)).astype(np.float64)
    extension = _extension(gltf.item("accessors", index)) or {}
    try:
        low, high = (np.array(extension[name], np.float64).reshape(3) for name in ("decodeMin", "decodeMax"))
    except (KeyError, TypeError, ValueError):
        raise FrameError(
            gltf.path, f"accessors[{index}]: expected decodeMin and decodeMax of 3 numbers", REMEDY
        ) from None
    return low + values * ((high - low) / most)


def _video(gltf: Gltf, folder: Path, extension: dict[str, Any]) -> Path | None:
    timeline = extension.get("timeline")
    if not isinstance(timeline, list) or not timeline:
        return None
    if len(timeline) > 1:
        raise FrameError(gltf.path, f"its texture is cut into {len(timeline)} videos", "export it with one video")
    uri = gltf.item("images", timeline[0].get("image") if isinstance(timeline[0], dict) else None).get("uri")
    file = find_named(unquote(str(uri)), gltf.path, capture_roots(gltf.path, folder))
    if file is None:
        raise FrameError(gltf.path, f'its video "{uri}" is not there', "put the video beside it")
    return file


def _extension(item: Any) -> dict[str, Any] | None:
    found = item.get("extensions", {}) if isinstance(item, dict) else {}
    own = found.get(NAME) if isinstance(found, dict) else None
    return own if isinstance(own, dict) else None
