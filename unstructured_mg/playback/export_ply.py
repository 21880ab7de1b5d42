"""Sequences of PLY + image, and the same as Unity's Geometry Sequence Player takes them."""

import io
import json
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from PIL import Image

from unstructured_mg.errors import UserError
from unstructured_mg.geometry.split_seams import split_seams
from unstructured_mg.playback.export_format import ExportFrame, Format, Target
from unstructured_mg.playback.stream import EncodedImage


@dataclass(frozen=True)
class Written:
    """A frame that was written for Unity: what its ``sequence.json`` says of it."""

    file: str
    header_bytes: int
    vertices: int
    indices: int
    low: np.ndarray
    high: np.ndarray
    texture: tuple[int, int] | None


def write_frame(frame: ExportFrame, target: Target) -> str:
    """Write ``frame_00001.ply``, little-endian, a uv or a colour a vertex, and its image, named in a comment."""
    _one_texture(frame, target)
    stem = target.stem(frame.number)
    image = None
    if frame.textures:
        image = f"{stem}{frame.textures[0].suffix}"
        (target.folder / image).write_bytes(frame.textures[0].data)
    _write(frame, target, frame.vertices(), image, frame.colors)
    return f"{stem}.ply"


def write_unity_frame(frame: ExportFrame, target: Target) -> Written:
    """Write ``frame_00001.ply`` and ``frame_00001.dds`` (BC1) in Unity's left-handed space: x is turned about.

    In a mirrored triangle the corners run the other way round, which is Unity's custom too.
    """
    _one_texture(frame, target)
    vertices = frame.vertices() * [-1.0, 1.0, 1.0]
    stem = target.stem(frame.number)
    texture = None
    if frame.textures:
        data, texture = _block_compressed(frame.textures[0])
        (target.folder / f"{stem}.dds").write_bytes(data)
    header_bytes, count = _write(frame, target, vertices, None, None)
    used = vertices[np.unique(frame.faces)]
    return Written(f"{stem}.ply", header_bytes, count, frame.faces.size, used.min(axis=0), used.max(axis=0), texture)


def name_files(written: Iterator[str], target: Target) -> list[str]:
    return list(written)


def describe(written: Iterator[Written], target: Target) -> list[str]:
    """Write ``sequence.json``; UserError where the textures differ in size, which the player cannot show."""
    frames = list(written)
    sizes = {frame.texture for frame in frames}
    if len(sizes) > 1:
        listed = " and ".join(sorted("none" if size is None else f"{size[0]} x {size[1]}" for size in sizes)[:2])
        raise UserError(
            f"{target.folder.name}: the player takes textures of one size only, and there are {listed}; give a "
            "--texture-size that makes them alike, or export another format."
        )
    (size,) = sizes
    low = np.min([frame.low for frame in frames], axis=0)
    high = np.max([frame.high for frame in frames], axis=0)
    told = {
        "geometryType": 1 if size is None else 2,
        "textureMode": 0 if size is None else 2,
        "DDS": size is not None,
        "ASTC": False,
        "hasUVs": size is not None,
        "hasNormals": False,
        "useCompression": False,
        "maxVertexCount": max(frame.vertices for frame in frames),
        "maxIndiceCount": max(frame.indices for frame in frames),
        "boundsCenter": dict(zip("xyz", ((low + high) / 2).tolist(), strict=True)),
        "boundsSize": dict(zip("xyz", (high - low).tolist(), strict=True)),
        "textureWidth": 0 if size is None else size[0],
        "textureHeight": 0 if size is None else size[1],
        "textureSizeDDS": 0 if size is None else size[0] * size[1] // 2,  # BC1: half a byte a texel
        "textureSizeASTC": 0,
        "headerSizes": [frame.header_bytes for frame in frames],
        "verticeCounts": [frame.vertices for frame in frames],
        "indiceCounts": [frame.indices for frame in frames],
    }
    (target.folder / "sequence.json").write_text(json.dumps(told) + "\n")
    return [frame.file for frame in frames]


def _one_texture(frame: ExportFrame, target: Target) -> None:
    if len(frame.textures) > 1:
        raise UserError(
            f"{target.stem(frame.number)}.ply: PLY holds one texture, and this frame has {len(frame.textures)}; export "
            "obj, glb or usd."
        )


def _write(
    frame: ExportFrame, target: Target, vertices: np.ndarray, image: str | None, colors: np.ndarray | None
) -> tuple[int, int]:
    """Bytes of the header, and vertices written."""
    textured = len(frame.textures) > 0
    vertex_index, uv_index, faces = split_seams(frame.faces, frame.face_uv if textured else frame.face_uv[:0])
    fields = [(name, "<f4", "float") for name in ("x", "y", "z")]
    fields += [(name, "<f4", "float") for name in ("s", "t") if textured]
    fields += [(name, "u1", "uchar") for name in ("red", "green", "blue") if colors is not None]
    rows = np.empty(len(vertex_index), [(name, kind) for name, kind, _ in fields])
    for axis, name in enumerate(("x", "y", "z")):
        rows[name] = vertices[vertex_index, axis]
    if textured:
        rows["s"], rows["t"] = frame.uv[uv_index].T
    if colors is not None:
        rows["red"], rows["green"], rows["blue"] = colors[vertex_index].T
    corners = np.empty(len(faces), [("count", "u1"), ("corners", "<u4", 3)])
    corners["count"], corners["corners"] = 3, faces
    lines = ["ply", "format binary_little_endian 1.0"]
    lines += [] if image is None else [f"comment TextureFile {image}"]
    lines += [f"element vertex {len(rows)}", *(f"property {word} {name}" for name, _, word in fields)]
    lines += [f"element face {len(faces)}", "property list uchar uint vertex_indices", "end_header\n"]
    header = "\n".join(lines).encode()
    with (target.folder / f"{target.stem(frame.number)}.ply").open("wb") as stream:
        for part in (header, rows.tobytes(), corners.tobytes()):
            stream.write(part)
    return len(header), len(rows)


def _block_compressed(texture: EncodedImage) -> tuple[bytes, tuple[int, int]]:
    """A DDS file of BC1 without mips, top row first, and its width and height: the image's, made multiples of four."""
    with Image.open(io.BytesIO(texture.data)) as image:
        pixels = image.convert("RGB")
    size = (max(4, pixels.width // 4 * 4), max(4, pixels.height // 4 * 4))
    if pixels.size != size:
        pixels = pixels.resize(size, Image.Resampling.LANCZOS)
    data = io.BytesIO()
    pixels.save(data, "DDS", pixel_format="DXT1")
    return data.getvalue(), size


PLY = Format("ply", r"frame_\d{5,}\.\w+", write_frame, name_files)
UNITY = Format("unity", r"frame_\d{5,}\.(ply|dds)|sequence\.json", write_unity_frame, describe, space=("y", 1.0))
