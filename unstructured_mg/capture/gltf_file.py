"""glTF 2 files (.glb and .gltf): their JSON, and accessors as arrays, every byte range checked before it is read."""

import base64
import binascii
import json
import struct
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeGuard
from urllib.parse import unquote

import numpy as np

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.paths import capture_roots, find_named
from unstructured_mg.capture.stretch import file_stamp, read_stretch

REMEDY = "export the file again"
_LARGEST_JSON = 1 << 28
_JSON, _BIN = b"JSON", b"BIN\0"
_KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_MOST_SPARSE = 1 << 24
# Extensions that change what the file means and that are understood; others that it requires are refused.
_UNDERSTOOD = {
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
    "KHR_texture_basisu",
    "EXT_texture_webp",
    "KHR_texture_transform",
    "KHR_materials_unlit",
    "KHR_node_visibility",
    "KHR_animation_pointer",
    "HCAP_holovideo",
}


@dataclass(frozen=True)
class GltfBuffer:
    """Where a buffer's bytes are: from byte ``start`` of ``path``, or, embedded as text, in ``data``."""

    path: Path
    start: int
    size: int
    data: bytes | None = None


@dataclass(frozen=True, eq=False)
class Gltf:
    """An open file: its JSON object and where its buffers lie.

    Equal only to itself, so that what was worked out of it can be remembered.
    """

    path: Path
    data: dict[str, Any]
    buffers: tuple[GltfBuffer, ...]

    def item(self, kind: str, index: Any) -> dict[str, Any]:
        """Object ``index`` of the list ``kind`` ("meshes", "nodes", ...). Raises FrameError where there is none."""
        items = self.data.get(kind)
        if (
            not isinstance(items, list)
            or not is_index(index)
            or index >= len(items)
            or not isinstance(items[index], dict)
        ):
            count = len(items) if isinstance(items, list) else 0
            raise FrameError(self.path, f"it names {kind}[{index}], but has {count} {kind}", REMEDY)
        return dict(items[index])

    def files(self) -> tuple[Path, ...]:
        """The file itself and those that hold its buffers."""
        return tuple(dict.fromkeys([self.path, *(buffer.path for buffer in self.buffers)]))


def open_gltf(path: Path, folder: Path) -> Gltf:
    """Open a .glb or .gltf; ``folder`` is the capture's: nothing outside is touched.

    Raises
    ------
    FrameError : not glTF 2, cut off, or lying about its length; names the byte and what was expected
    """
    return _open(path, folder, file_stamp(path))


@lru_cache(maxsize=4)
def _open(path: Path, folder: Path, stamp: tuple[int, int]) -> Gltf:
    size = stamp[0]
    binary: GltfBuffer | None = None
    if size >= 4 and read_stretch(path, 0, 4, "its first word") == b"glTF":
        text, binary = _chunks(path, size)
    elif path.suffix.lower() == ".glb":
        found = read_stretch(path, 0, min(size, 4), "its first word")
        raise FrameError(path, f"byte 0: expected glTF, found {found.hex(' ') or 'nothing'}", REMEDY)
    else:
        if size > _LARGEST_JSON:
            raise FrameError(path, f"its JSON has {size} bytes", "export it as .glb")
        text = read_stretch(path, 0, size, "its JSON")
    try:
        data = json.loads(text.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise FrameError(path, f"its JSON cannot be read ({error})", REMEDY) from None
    if not isinstance(data, dict):
        raise FrameError(path, "its JSON holds no object", REMEDY)
    version = data.get("asset", {}).get("version") if isinstance(data.get("asset"), dict) else None
    if not str(version).startswith("2"):
        raise FrameError(path, f"expected glTF of version 2, found {version}", "export it as glTF 2")
    required = data.get("extensionsRequired", [])
    unknown = [str(name) for name in required if name not in _UNDERSTOOD] if isinstance(required, list) else []
    if unknown:
        raise FrameError(path, f"it cannot be read without {', '.join(unknown)}", "export it without that")
    listed = data.get("buffers", [])
    roots = capture_roots(path, folder)
    buffers = [
        _buffer(path, roots, item, index, binary)
        for index, item in enumerate(listed if isinstance(listed, list) else [])
    ]
    return Gltf(path, data, tuple(buffers))


def _chunks(path: Path, size: int) -> tuple[bytes, GltfBuffer | None]:
    """The JSON text and where the binary chunk is."""
    head = read_stretch(path, 0, 12, "the GLB header")
    version, length = struct.unpack_from("<2I", head, 4)
    if version != 2:
        raise FrameError(path, f"byte 4: expected version 2, found {version}", "export it as glTF 2")
    if length > size:
        raise FrameError(path, f"it ends at byte {size}, but byte 8 promises {length} bytes", REMEDY)
    at, text, binary = 12, None, None
    while at + 8 <= length:
        chunk_size, kind = struct.unpack("<I4s", read_stretch(path, at, 8, "a chunk's header"))
        if at + 8 + chunk_size > size:
            raise FrameError(
                path,
                f"it ends at byte {size}, but the chunk at byte {at} should reach to {at + 8 + chunk_size}",
                REMEDY,
            )
        if kind == _JSON and text is None:
            if chunk_size > _LARGEST_JSON:
                raise FrameError(path, f"byte {at}: its JSON takes {chunk_size} bytes", REMEDY)
            text = read_stretch(path, at + 8, chunk_size, "its JSON")
        elif kind == _BIN and binary is None:
            binary = GltfBuffer(path, at + 8, chunk_size)
        at += 8 + chunk_size
    if text is None:
        raise FrameError(path, "byte 12: expected a JSON chunk, found none", REMEDY)
    return text, binary


def _buffer(path: Path, roots: tuple[Path, ...], item: Any, index: int, binary: GltfBuffer | None) -> GltfBuffer:
    size = item.get("byteLength") if isinstance(item, dict) else None
    if not is_index(size):
        raise FrameError(path, f"buffers[{index}] states no length", REMEDY)
    uri = item.get("uri")
    if uri is None:
        if index > 0 or binary is None:
            raise FrameError(path, f"buffers[{index}] is nowhere: there is no binary chunk for it", REMEDY)
        found = binary
    elif isinstance(uri, str) and uri.startswith("data:"):
        try:
            data = base64.b64decode(uri.partition(",")[2], validate=True)
        except (ValueError, binascii.Error):
            raise FrameError(path, f"buffers[{index}] is not readable as base64", REMEDY) from None
        found = GltfBuffer(path, 0, len(data), data)
    else:
        file = find_named(unquote(str(uri)), path, roots)
        if file is None:
            raise FrameError(path, f'its buffer "{uri}" is not there', "put that file beside it")
        found = GltfBuffer(file, 0, file_stamp(file)[0])
    if found.size < size:
        raise FrameError(
            found.path,
            f"it ends at byte {found.start + found.size}, but buffers[{index}] should reach to {found.start + size}",
            REMEDY,
        )
    return found


def view_stretch(gltf: Gltf, index: Any) -> tuple[GltfBuffer, int, int]:
    """The buffer of bufferView ``index``, and the view's start in the buffer's file (or data) and size in bytes."""
    view = gltf.item("bufferViews", index)
    buffer_index, offset, size = view.get("buffer"), view.get("byteOffset", 0), view.get("byteLength")
    if not is_index(buffer_index) or buffer_index >= len(gltf.buffers):
        raise FrameError(gltf.path, f"bufferViews[{index}] names buffer {buffer_index}, which is not there", REMEDY)
    buffer = gltf.buffers[buffer_index]
    if not is_index(offset) or not is_index(size) or offset + size > buffer.size:
        raise FrameError(
            gltf.path,
            f"bufferViews[{index}] should take {size} bytes from byte {offset} of its buffer, which has {buffer.size}",
            REMEDY,
        )
    if "EXT_meshopt_compression" in view.get("extensions", {}):
        raise FrameError(gltf.path, "its arrays are compressed by meshopt, which is not supported", "use Draco or none")
    return buffer, buffer.start + offset, size


def read_view(gltf: Gltf, index: Any) -> bytes:
    buffer, start, size = view_stretch(gltf, index)
    if buffer.data is not None:
        return buffer.data[start : start + size]
    return read_stretch(buffer.path, start, size, f"bufferViews[{index}]")


def read_accessor(gltf: Gltf, index: Any, kinds: tuple[str, ...]) -> np.ndarray:
    """The values of an accessor of one of these types: ``(n,)`` for SCALAR, else ``(n, k)``. Normalised integers become
    float64 in [0, 1] or [-1, 1], others stay what they are.

    Raises FrameError where it is of another type, or its bytes are not all there.
    """
    item = gltf.item("accessors", index)
    where = f"accessors[{index}]"
    kind, count = item.get("type"), item.get("count")
    component = item.get("componentType")
    if kind not in kinds or not isinstance(kind, str):
        raise FrameError(gltf.path, f"{where}: expected {' or '.join(kinds)}, found {kind}", REMEDY)
    if not is_index(component) or component not in _KINDS:
        raise FrameError(gltf.path, f"{where}: expected a component type, found {component}", REMEDY)
    if not is_index(count) or count == 0:
        raise FrameError(gltf.path, f"{where}: expected a count above 0, found {count}", REMEDY)
    dtype, width = np.dtype(_KINDS[component]), _WIDTHS[kind]
    if "bufferView" in item:
        values = _strided(gltf, item, where, dtype, width, count)
    elif "sparse" in item and count <= _MOST_SPARSE:
        values = np.zeros((count, width), dtype)
    else:
        raise FrameError(gltf.path, f"{where}: expected data, found none for its {count} values", REMEDY)
    if "sparse" in item:
        values = _sparse(gltf, item["sparse"], where, values, dtype, width)
    if item.get("normalized") and dtype.kind in "iu":
        values = np.maximum(values / np.iinfo(dtype).max, -1.0)
    return values[:, 0] if kind == "SCALAR" else values


def _strided(gltf: Gltf, item: dict[str, Any], where: str, dtype: np.dtype, width: int, count: int) -> np.ndarray:
    view = gltf.item("bufferViews", item["bufferView"])
    row = dtype.itemsize * width
    stride, offset = view.get("byteStride", row), item.get("byteOffset", 0)
    if not is_index(stride) or not is_index(offset) or not row <= stride <= 65535:
        raise FrameError(gltf.path, f"{where}: expected rows of {row} bytes or more, found {stride}", REMEDY)
    buffer, start, size = view_stretch(gltf, item["bufferView"])
    needed = offset + stride * (count - 1) + row
    if needed > size:
        place = f", which ends at byte {start + size} of {buffer.path.name}" if buffer.data is None else ""
        raise FrameError(
            gltf.path,
            f"{where}: its {count} values need {needed} bytes, but bufferViews[{item['bufferView']}] has {size}{place}",
            REMEDY,
        )
    if buffer.data is None:
        data = read_stretch(buffer.path, start + offset, needed - offset, where)
    else:
        data = buffer.data[start + offset : start + needed]
    if stride == row:
        return np.frombuffer(data, dtype).reshape(count, width)
    padded = np.frombuffer(data + bytes(stride - row), np.uint8).reshape(count, stride)
    return np.ascontiguousarray(padded[:, :row]).view(dtype).reshape(count, width)


def _sparse(gltf: Gltf, sparse: Any, where: str, values: np.ndarray, dtype: np.dtype, width: int) -> np.ndarray:
    count = sparse.get("count") if isinstance(sparse, dict) else None
    places, replaced = (sparse.get("indices"), sparse.get("values")) if isinstance(sparse, dict) else (None, None)
    if not is_index(count) or count == 0 or not isinstance(places, dict) or not isinstance(replaced, dict):
        raise FrameError(gltf.path, f"{where}: expected a sparse part with indices and values", REMEDY)
    component = places.get("componentType")
    if component not in (5121, 5123, 5125):
        raise FrameError(gltf.path, f"{where}: expected sparse indices of an unsigned type, found {component}", REMEDY)
    rows = _strided(gltf, places, where, np.dtype(_KINDS[component]), 1, count)[:, 0]
    if rows.max() >= len(values):
        raise FrameError(gltf.path, f"{where}: expected sparse indices below {len(values)}, found {rows.max()}", REMEDY)
    values = values.copy()
    values[rows] = _strided(gltf, replaced, where, dtype, width, count)
    return values


def is_index(value: Any) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0
