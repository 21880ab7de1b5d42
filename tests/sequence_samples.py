"""Small files of many frames for tests, packed byte by byte as their formats' descriptions have it."""

import base64
import json
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
from broken_captures import BODY_FACES, BODY_UV, BODY_VERTICES

# Three layers of 16 x 8 pixels as ETC1S video, two as UASTC, and a .basis file of one, written by the encoder of Basis
# Universal 1.50 (npm ktx2-encoder 0.5.1) from the pictures that ``layer_picture`` gives.
ETC1S_VIDEO = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAQAAAACAAAAAAAAAADAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAAAAAA0QAAAAAAAACJAQ"
    "AAAAAAAA0AAAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAAAAAAAAAAAAAA/AAAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFz"
    "aXMgVW5pdmVyc2FsIDEuNTAAAAwABABBAAAAEQAAAC8AAAAAAAAAAAAAAAAAAAAEAAAAAAAAAAAAAAACAAAABAAAAAQAAAAAAAAAAAAAAAIAAA"
    "AIAAAABQAAAAAAAAAAAAAAIEAkAQEAgADYniAjFwECPAEQAAAAIslXbB5A1AQAAABA2A4gDBYEIAKAAAAAEGjUsLqxJyMF5C3vb1MBcuOTFAr8"
    "////V1VVVQUAAACoqqqqAjTARAAAAAAAABKFAZgBAAAAAACCYBg6Ad4GDAAADEnpaHQCAoAJAAAAAAAABBAAILBuLEZg3VhCYP2zAA=="
)
UASTC_ARRAY = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAQAAAACAAAAAAAAAACAAAAAQAAAAEAAAAAAAAAaAAAACwAAACUAAAALAAAAAAAAAAAAAAAAAAAAAAAAADAAA"
    "AAAAAAAAABAAAAAAAAAAEAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AAAAAAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFz"
    "aXMgVW5pdmVyc2FsIDEuNTAAAAQAAAB/fwAAF5kW4F9iCwAAAAAAAAAAABeZFuBfYgsAAAAAAAAAAAAXhRbgvzIXAAAAAAAAAAAAF4UW4L8yFw"
    "AAAAAAAAAAABfZA+BfYgIAAAAAAAAAAAAX2QPgX2ICAAAAAAAAAAAAF8UD4D9hCwAAAAAAAAAAABfFA+A/YQsAAAAAAAAAAAAXmVbrv6XyAAAA"
    "AAAAAAAAF5lW67+l8gAAAAAAAAAAABeFVuu/MpcBAAAAAAAAAAAXhVbrvzKXAQAAAAAAAAAAF9lD6z++QwEAAAAAAAAAABfZQ+s/vkMBAAAAAA"
    "AAAAAXxUPrPzumAQAAAAAAAAAAF8VD6z87pgEAAAAAAAAAAA=="
)
ETC1S_BASIS = base64.b64decode(
    "c0ITAE0AYDqHAAAAhTEBAAABAAAAEQAAAAAAAAAAAAAAAAAAAAAABABkAAAAMgAAAwCWAAAADQAAowAAAC0AAABNAAAAAAAAAAAAAAAAAAAAAB"
    "AACAAEAAIA0AAAAAQAAADuYyDAlAAAAABAGLYOx2MBTAkAAAAAAEEXDPIATAQAAAAAACAKHABTAAAAAAAgkA45nXMAVFVVVQUAAACoqqqqAjTA"
    "RAAAAAAAABKFAJgBAAAAAABAQgkQN2AAAAAIFjoanUAAMAEAAAAAAIAAAmj4QAM="
)


def layer_picture(layer: int) -> np.ndarray:
    """(8, 16, 3) uint8: what a layer of the samples was encoded from; four even fields."""
    picture = np.empty((8, 16, 3), np.uint8)
    picture[:, :8, 0], picture[:, 8:, 0] = 200, 40
    picture[:4, :, 1], picture[4:, :, 1] = 180, 30
    picture[:, :, 2] = 90 * layer
    return picture


def moved_body(frame: int) -> np.ndarray:
    """(n, 3) float32: the body, a little further at every frame."""
    return (BODY_VERTICES + [0.01 * frame, 0, 0.02 * frame]).astype(np.float32)


def vols_header(
    version: int, frames: int, *, normals: bool = False, textured: bool = False, fps: float = 25.0
) -> bytes:
    def text(word: str) -> bytes:
        return bytes([len(word)]) + word.encode()

    if version == 13:
        head = b"VOLS" + struct.pack("<III", 13, 0, frames) + bytes([normals, textured, 1, 2])
        return head + struct.pack("<IIfIII", 16, 8, fps, 0, 0, 44)
    head = (
        text("VOLS")
        + struct.pack("<ii", version, 0)
        + text("mesh")
        + text("material")
        + text("")
        + struct.pack("<ii", 0, frames)
    )
    if version >= 11:
        head += bytes([normals, textured]) + struct.pack("<HHH", 16, 8, 0)
    if version >= 12:
        head += struct.pack("<8f", 0, 0, 0, 1, 0, 0, 0, 1)
    return head


def vols_frame(
    version: int,
    number: int,
    vertices: np.ndarray,
    *,
    kind: int,
    faces: np.ndarray = BODY_FACES,
    uv: np.ndarray = BODY_UV,
    normals: bool = False,
    texture: bytes | None = None,
) -> bytes:
    """One frame, x turned and triangles reversed as Unity has them; the arrays' own size fields count from 1.2 on."""

    def array(values: np.ndarray | bytes) -> bytes:
        data = values if isinstance(values, bytes) else values.tobytes()
        return struct.pack("<i", len(data)) + data

    turned = (vertices * [-1, 1, 1]).astype("<f4")
    arrays = [array(turned)]
    if normals:
        arrays.append(array(np.zeros_like(turned)))
    if kind == 1 or (kind == 2 and version >= 12):
        width = "<u2" if len(vertices) < 65535 else "<u4"
        arrays += [array(faces[:, ::-1].astype(width)), array(uv.astype("<f4"))]
    if texture is not None:
        arrays.append(array(texture))
    size = sum(map(len, arrays)) - (0 if version >= 12 else 4 * (len(arrays) - 1))
    return struct.pack("<iiB", number, size, kind) + b"".join(arrays) + struct.pack("<i", size)


def glb(data: dict, binary: bytes) -> bytes:
    """A GLB file of this JSON and binary chunk."""
    text = json.dumps({"asset": {"version": "2.0"}, "buffers": [{"byteLength": len(binary)}], **data}).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


class Packer:
    """Accessors for a GLB file, one after the other in its binary chunk."""

    KINDS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}

    def __init__(self) -> None:
        self.binary, self.views, self.accessors = b"", [], []

    def view(self, data: bytes) -> int:
        self.binary += bytes(-len(self.binary) % 4)
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data
        return len(self.views) - 1

    def add(self, values: np.ndarray, kind: str, **more: object) -> int:
        values = np.ascontiguousarray(values, "<" + kind)
        width = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[values.shape[1] if values.ndim == 2 else 1]
        view = self.view(values.tobytes())
        self.accessors.append(
            {"bufferView": view, "componentType": self.KINDS[kind], "count": len(values), "type": width, **more}
        )
        return len(self.accessors) - 1

    def glb(self, data: dict) -> bytes:
        return glb({"bufferViews": self.views, "accessors": self.accessors, **data}, self.binary)


def write_video(path: Path, pictures: list[np.ndarray], fps: int = 30) -> Path:
    """An MPEG-4 video of these pictures, one a frame, by ffmpeg."""
    program = shutil.which("ffmpeg")
    if program is None:
        from imageio_ffmpeg import get_ffmpeg_exe

        program = get_ffmpeg_exe()
    height, width = pictures[0].shape[:2]
    command = [program, "-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(fps)]
    command += ["-i", "-", "-c:v", "mpeg4", "-q:v", "1", str(path)]
    subprocess.run(command, input=b"".join(p.tobytes() for p in pictures), check=True)
    return path
