"""The page's files read as docs/files.md describes them, without the program's own writer or player."""

import io
import json
import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image


@dataclass(frozen=True)
class SiteFile:
    """What a file holds: ``positions (steps, c, 3)`` in metres, ``faces (m, 3)`` over c corners, ..."""

    name: str
    header: dict[str, Any]
    positions: np.ndarray
    faces: np.ndarray
    uv: np.ndarray | None
    flow: np.ndarray | None
    colors: np.ndarray
    images: list[np.ndarray]


def read_site_json(site: Path) -> dict[str, Any]:
    text = (site / "site.js").read_text(encoding="utf-8")
    return json.loads(re.fullmatch(r'umg\.take\("site",(.*)\)\n', text, re.DOTALL).group(1))


def script_data(content: bytes) -> tuple[str, bytes]:
    """The name and the bytes that a script hands over."""
    head, string = re.fullmatch(rb'umg\.take\("([^"]*)","(.*)"\)\n', content, re.DOTALL).groups()
    assert not re.search(rb'[\n\r\0]|(?<!\\)(\\\\)*"', string)
    meaning = {b"\\\\": b"\\", b'\\"': b'"', b"\\n": b"\n", b"\\r": b"\r", b"\\x00": b"\0"}
    data = re.sub(rb'\\(?:x00|[\\"nr])', lambda found: meaning[found.group()], string)
    return head.decode(), zlib.decompress(data)


def read_site_file(content: bytes) -> SiteFile:
    name, data = script_data(content)
    length = int.from_bytes(data[:4], "little")
    header, at = json.loads(data[4 : 4 + length]), 4 + length

    def columns(rows: int, count: int, kind: type) -> np.ndarray:
        nonlocal at
        size = np.dtype(kind).itemsize
        values = np.zeros((rows, count), np.int64)
        for column in range(count):
            planes = np.frombuffer(data, np.uint8, rows * size, at).reshape(size, rows).astype(np.int64)
            at += rows * size
            folded = sum(plane << (8 * place) for place, plane in enumerate(planes))
            values[:, column] = np.cumsum(np.where(folded % 2, -(folded + 1) // 2, folded // 2))
        return values % (1 << (8 * size))

    corners, steps = header["corners"], header["steps"]
    written = [columns(corners, 3, np.uint16) for _ in range(steps)]
    positions = written[:1]
    for step in range(1, steps):
        last = positions[-1] if step == 1 else 2 * positions[-1] - positions[-2]
        positions.append((last + written[step]) % 65536)
    kind = np.uint16 if corners <= 65535 else np.uint32
    first, second, third = columns(header["faces"], 3, kind).T
    limit = 1 << (8 * np.dtype(kind).itemsize)
    faces = np.stack([first, (first + second) % limit, (first + second + third) % limit], axis=1)
    uv = flow = None
    if header["uv"]:
        uv = columns(corners, 2, np.uint16) * header["uv"]["step"] + header["uv"]["low"]
    if header.get("flow"):
        flow = columns(corners, 2, np.uint16) * header["flow"]["step"] + header["flow"]["low"]
    colors = np.array([columns(corners, 3, np.uint8) for _ in range(header["colors"])])
    images = []
    for image in header["images"]:
        with Image.open(io.BytesIO(data[at : at + image["bytes"]])) as opened:
            images.append(np.asarray(opened.convert("RGB")))
        at += image["bytes"]
    assert at == len(data)
    places = np.array(positions) * header["step"] + header["low"]
    return SiteFile(name, header, places, faces, uv, flow, colors, images)
