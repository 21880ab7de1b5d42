"""Volograms: ``.vols`` of header 1.0 to 1.3, one file or header and sequence, the texture inside or as a video."""

import re
import struct
from dataclasses import dataclass
from functools import lru_cache
from io import BufferedReader
from pathlib import Path

import numpy as np

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.stretch import file_stamp, read_stretch
from unstructured_mg.capture.texture import Texture
from unstructured_mg.capture.video import VIDEO_SUFFIXES

_REMEDY = "copy or export the vologram again"
_LONGEST_HEADER = 1 << 12
# Vertices from which on indices have four bytes.
_LONG_INDICES = 65535
_TRIANGLES = (0, 1)  # Unity's number for them, and zero-based OpenGL exporters' one
_IMAGES = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg"}
_KTX2 = b"\xabKTX 20\xbb\r\n\x1a\n"
_BASIS = b"sB"


@dataclass(frozen=True)
class _Header:
    version: int
    frame_count: int
    normals: bool
    textured: bool
    fps: float | None
    body: int  # where the frames begin, in the file that holds them


@dataclass(frozen=True)
class VolsFrame:
    """Where a frame lies in its file: ``(start, size)`` in bytes of the whole and of each array; ``key`` is the index
    of the frame whose indices and uvs it has.
    """

    number: int
    key: int
    whole: tuple[int, int]
    vertices: tuple[int, int]
    indices: tuple[int, int] | None
    uv: tuple[int, int] | None
    texture: tuple[int, int] | None


@dataclass(frozen=True)
class Vols:
    """A vologram's frames, what its header says of their rate, its video, and what is wrong behind the last one."""

    path: Path
    header: Path
    frames: tuple[VolsFrame, ...]
    fps: float | None
    video: Path | None
    fault: FrameError | None


def vols_files(names: list[str]) -> list[str]:
    """Of a folder's ``.vols`` files those that hold frames: not the header that has its frames in a file of its own."""
    return [name for name in names if name.lower() != "header.vols" or len(names) == 1]


def open_vols(path: Path) -> Vols:
    """Find every frame of the vologram at ``path``, the file that holds the frames, by their headers alone.

    Raises
    ------
    FrameError : the header, or the first frame, is not what it should be; names the byte and what was expected there.
        What is wrong further on is in ``fault``, and the frames before it are good
    """
    header = path.with_name(next((p.name for p in path.parent.glob("[hH]eader.[vV][oO][lL][sS]")), path.name))
    return _open(path, header, file_stamp(path), file_stamp(header))


@lru_cache(maxsize=8)
def _open(path: Path, header_path: Path, stamp: tuple[int, int], header_stamp: tuple[int, int]) -> Vols:
    header = _read_header(header_path, header_stamp[0])
    frames: list[VolsFrame] = []
    fault = None
    with open(path, "rb") as file:
        at, key = (header.body if header_path == path else 0), -1
        while len(frames) < header.frame_count:
            try:
                if at >= stamp[0]:
                    raise FrameError(
                        path,
                        f"it ends at byte {stamp[0]} after {len(frames)} of the {header.frame_count} frames promised",
                        _REMEDY,
                    )
                frame = _read_frame_header(file, path, at, stamp[0], header, key, len(frames))
                if frames and frame.number <= frames[-1].number:
                    raise FrameError(
                        path,
                        f"byte {at}: expected a frame number above {frames[-1].number}, found {frame.number}",
                        _REMEDY,
                    )
            except FrameError as error:
                if not frames:
                    raise
                fault = error
                break
            frames.append(frame)
            key = frame.key
            at = frame.whole[0] + frame.whole[1]
    return Vols(path, header_path, tuple(frames), header.fps, None if header.textured else _video(path), fault)


def read_vols(path: Path, folder: Path, part: int) -> RawMesh:
    """Frame ``part``, by its position in the file, y up, with x turned to right-handed as Volograms' converter does.

    A tracked frame has the indices and uvs of the last key frame before it. Raises FrameError as ``open_vols``, also
    for arrays that do not fit each other.
    """
    vols = open_vols(path)
    if part >= len(vols.frames):
        raise vols.fault or FrameError(path, f"it has no frame {part} any more", "inspect the capture again")
    frame, key = vols.frames[part], vols.frames[vols.frames[part].key]
    vertices = _array(path, frame.vertices, "<f4", "vertices").reshape(-1, 3).astype(np.float64)
    assert key.indices is not None and key.uv is not None
    indices = _array(path, key.indices, "<u2" if len(vertices) < _LONG_INDICES else "<u4", "indices")
    uv = _array(path, key.uv, "<f4", "texture coordinates").reshape(-1, 2).astype(np.float64)
    if len(uv) not in (0, len(vertices)):
        raise FrameError(
            path,
            f"byte {key.uv[0]}: expected texture coordinates of the frame's {len(vertices)} vertices, found {len(uv)}",
            _REMEDY,
        )
    if len(indices) == 0 or len(indices) % 3:
        raise FrameError(path, f"byte {key.indices[0]}: expected triangles, found {len(indices)} indices", _REMEDY)
    if indices.max() >= len(vertices):
        first = int(np.argmax(indices >= len(vertices)))
        raise FrameError(
            path,
            f"byte {key.indices[0] + first * indices.itemsize}: expected an index below {len(vertices)}, "
            f"found {indices[first]}",
            _REMEDY,
        )
    vertices[:, 0] *= -1
    faces = indices.reshape(-1, 3)[:, ::-1].astype(np.int32)
    texture = _texture(vols, frame, part)
    stretches = tuple(dict.fromkeys([frame.whole, key.whole]))
    return RawMesh(
        vertices=vertices,
        faces=faces,
        uv=uv,
        face_uv=faces.copy() if len(uv) else np.full_like(faces, -1),
        images=() if texture is None else (texture,),
        face_image=np.full(len(faces), -1 if texture is None else 0, np.int32),
        files=(path,) if vols.video is None else (path, vols.video),
        stretches=stretches,
    )


def _array(path: Path, stretch: tuple[int, int], kind: str, what: str) -> np.ndarray:
    return np.frombuffer(read_stretch(path, *stretch, what), kind)


def _texture(vols: Vols, frame: VolsFrame, part: int) -> Texture | None:
    if frame.texture is None:
        return None if vols.video is None else Texture(vols.video, coding="video", layer=part)
    start, size = frame.texture
    head = read_stretch(vols.path, start, min(size, 12), "a texture")
    if head == _KTX2 or head.startswith(_BASIS):
        return Texture(vols.path, start, size, "basis")
    for magic, suffix in _IMAGES.items():
        if head.startswith(magic):
            return Texture(vols.path, start, size, ending=suffix)
    raise FrameError(
        vols.path,
        f"byte {start}: expected a KTX2, Basis, PNG or JPEG texture, found {head[:4].hex(' ')}",
        "export the vologram with one of these, or with a video beside it",
    )


def _video(path: Path) -> Path | None:
    """The video beside a vologram: the one whose name states the largest resolution."""
    videos = [p for p in path.parent.iterdir() if p.suffix.lower() in VIDEO_SUFFIXES and not p.name.startswith(".")]
    return max(videos, key=lambda p: (max(map(int, re.findall(r"\d{3,5}", p.stem)), default=0), p.name), default=None)


def _read_frame_header(
    file: BufferedReader, path: Path, start: int, end: int, header: _Header, key: int, index: int
) -> VolsFrame:
    def number(at: int, what: str) -> int:
        if at + 4 > end:
            raise FrameError(path, f"it ends at byte {end}, where {what} of frame {index} should be", _REMEDY)
        file.seek(at)
        return int(struct.unpack("<i", file.read(4))[0])

    def array(at: int, what: str, step: int) -> tuple[int, int]:
        size = number(at, f"the size of the {what}")
        if size < 0 or size % step:
            raise FrameError(
                path, f"byte {at}: expected the size of the {what}, a multiple of {step}, found {size}", _REMEDY
            )
        if at + 4 + size > end:
            raise FrameError(
                path,
                f"byte {at}: the {what} of frame {index} should take {size} bytes, but the file ends at byte {end}",
                _REMEDY,
            )
        return at + 4, size

    frame_number, mesh_size = number(start, "the number"), number(start + 4, "the size")
    if frame_number < 0:
        raise FrameError(path, f"byte {start}: expected a frame number, found {frame_number}", _REMEDY)
    file.seek(start + 8)
    kind = file.read(1)
    if kind not in (b"\0", b"\1", b"\2"):
        raise FrameError(
            path, f"byte {start + 8}: expected 0, 1 or 2 for the kind of frame, found {kind.hex()}", _REMEDY
        )
    has_key = kind == b"\1" or (kind == b"\2" and header.version >= 12)
    if not has_key and key < 0:
        raise FrameError(path, f"byte {start + 8}: expected a key frame before any tracked frame", _REMEDY)
    vertices = array(start + 9, "vertices", 12)
    at = sum(vertices)
    if header.normals:
        at = sum(array(at, "normals", 12))
    indices = uv = texture = None
    if has_key:
        indices = array(at, "indices", 2)
        uv = array(sum(indices), "texture coordinates", 8)
        at = sum(uv)
    if header.textured:
        texture = array(at, "texture", 1)
        at = sum(texture)
    again = number(at, "the size at the end")
    if again != mesh_size:
        raise FrameError(path, f"byte {at}: expected the frame's size {mesh_size} again, found {again}", _REMEDY)
    if header.version >= 12 and start + 9 + mesh_size != at:
        raise FrameError(
            path, f"byte {start + 4}: expected the frame's size {at - start - 9}, found {mesh_size}", _REMEDY
        )
    whole = (start, at + 4 - start)
    return VolsFrame(frame_number, index if has_key else key, whole, vertices, indices, uv, texture)


def _read_header(path: Path, end: int) -> _Header:
    data = read_stretch(path, 0, min(end, _LONGEST_HEADER), "the header")
    at = 0

    def take(form: str, what: str) -> tuple:
        nonlocal at
        size = struct.calcsize("<" + form)
        if at + size > len(data):
            raise FrameError(path, f"it ends at byte {len(data)}, where {what} of the header should be", _REMEDY)
        at += size
        return struct.unpack_from("<" + form, data, at - size)

    def text(what: str) -> bytes:
        (size,) = take("B", f"the length of the {what}")
        return bytes(take(f"{size}s", f"the {what}")[0])

    magic = bytes(take("4s", "VOLS")[0]) if data.startswith(b"V") else text("word VOLS")
    if magic != b"VOLS":
        raise FrameError(path, f"byte 0: expected VOLS, found {data[:5].hex(' ')}", "give a Volograms file")
    (version,) = take("i", "the version")
    if version not in (10, 11, 12, 13):
        raise FrameError(
            path, f"byte {at - 4}: expected version 10 to 13, found {version}", "export it as one of these"
        )
    take("i", "the compression")
    if version < 13:
        for what in ("mesh's name", "material's name", "shader's name"):
            text(what)
        (topology,) = take("i", "the topology")
        if topology not in _TRIANGLES:
            raise FrameError(path, f"byte {at - 4}: expected triangles (0), found topology {topology}", _REMEDY)
    (frame_count,) = take("i", "the number of frames")
    if frame_count <= 0:
        raise FrameError(path, f"byte {at - 4}: expected the number of frames, found {frame_count}", _REMEDY)
    normals = textured = 0
    fps, body = None, 0
    if version >= 11:
        normals, textured = take("BB", "the texture's kind")
    if version == 13:
        _, _, _, _, rate, _, _, body = take("BBIIfIII", "the texture, the rate and where the frames begin")
        fps = float(rate) if np.isfinite(rate) and 0 < rate <= 1000 else None
        if not at <= body <= end:
            raise FrameError(
                path, f"byte {at - 4}: expected where the frames begin, {at} to {end}, found {body}", _REMEDY
            )
    elif version >= 11:
        take("HHH", "the texture's size")
    if version == 12:
        take("8f", "the placement")
    return _Header(version, frame_count, bool(normals), bool(textured), fps, body or at)
