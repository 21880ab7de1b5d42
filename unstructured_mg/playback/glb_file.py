"""A GLB file written piece by piece: its arrays never are in memory together."""

import json
import shutil
import struct
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from unstructured_mg.errors import UserError

# A GLB's length is a 32-bit number; of that its JSON takes a few kilobytes a frame.
MOST_BYTES = (1 << 32) - (1 << 28)
COMPONENTS = {
    np.dtype(np.uint8): 5121,
    np.dtype(np.uint16): 5123,
    np.dtype(np.uint32): 5125,
    np.dtype(np.float32): 5126,
}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
INDICES, VERTICES = 34963, 34962  # what a buffer view is for


class GlbFile:
    """Collects bytes in a nameless file beside ``path`` and the glTF's lists as text; ``finish`` puts them together.

    The glTF's lists are ``add``-ed to by name ("meshes", "nodes", ...), each giving the new item's index.
    """

    def __init__(self, path: Path):
        self.path = path
        self._lists: dict[str, list[str]] = {}
        self._bytes = tempfile.TemporaryFile(dir=path.parent)
        self._length = 0

    def __enter__(self) -> "GlbFile":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._bytes.close()

    def add(self, name: str, item: dict[str, Any]) -> int:
        items = self._lists.setdefault(name, [])
        items.append(json.dumps(item, separators=(",", ":")))
        return len(items) - 1

    def add_bytes(self, data: bytes, target: int | None = None) -> int:
        """A buffer view of ``data``; UserError where the file would become larger than a GLB can be."""
        view = {"buffer": 0, "byteOffset": self._length, "byteLength": len(data)}
        if target is not None:
            view["target"] = target
        padded = data + bytes(-len(data) % 4)
        self._bytes.write(padded)
        self._length += len(padded)
        if self._length > MOST_BYTES:
            raise UserError(
                f"{self.path.name}: the export has more than 4 GB, the most that a GLB can hold; export fewer frames, "
                "or use --decimate and --texture-size."
            )
        return self.add("bufferViews", view)

    def add_array(
        self, array: np.ndarray, target: int | None = None, bounds: bool = False, normalized: bool = False
    ) -> int:
        """An accessor of the rows of ``array``, (n,) or (n, 1 .. 4), with least and largest values where ``bounds``."""
        rows = np.ascontiguousarray(array).reshape(len(array), -1)
        accessor: dict[str, Any] = {
            "bufferView": self.add_bytes(rows.tobytes(), target),
            "componentType": COMPONENTS[rows.dtype],
            "count": len(rows),
            "type": KINDS[rows.shape[1]],
        }
        if normalized:
            accessor["normalized"] = True
        if bounds:
            accessor["min"], accessor["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
        return self.add("accessors", accessor)

    def finish(self, **rest: Any) -> None:
        """Write the file: ``rest`` is what the glTF has beside its lists and its buffer."""
        parts = [json.dumps(rest, separators=(",", ":"))[1:-1], f'"buffers":[{{"byteLength":{self._length}}}]']
        parts += [f'"{name}":[{",".join(items)}]' for name, items in self._lists.items()]
        text = ("{" + ",".join(parts) + "}").encode()
        text += b" " * (-len(text) % 4)
        length = 12 + 8 + len(text) + 8 + self._length
        with self.path.open("wb") as stream:
            stream.write(struct.pack("<4sII", b"glTF", 2, length))
            stream.write(struct.pack("<I4s", len(text), b"JSON"))
            stream.write(text)
            stream.write(struct.pack("<I4s", self._length, b"BIN\0"))
            self._bytes.seek(0)
            shutil.copyfileobj(self._bytes, stream, 1 << 20)
