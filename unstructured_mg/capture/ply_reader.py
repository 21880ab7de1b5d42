"""Reading one PLY frame: ASCII or binary of either byte order, with uv and image, or vertex colours."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.image import SUFFIXES
from unstructured_mg.capture.paths import capture_roots, decode_text, find_beside, find_named, read_regular_file
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.texture import Texture

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texture_s", "texture_t"))
_LONGEST_HEADER = 1 << 16


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str
    count_kind: str = ""  # of a list


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: list[_Property]


class _BadPly(Exception):
    """What is wrong with the file."""


def read_ply(path: Path, folder: Path) -> RawMesh:
    """Read a PLY mesh. ``folder`` is the capture's: nothing outside is touched.

    Understood: positions; uv a vertex (``s t``, ``u v``, ``texture_u texture_v``) or a corner (list ``texcoord``, with
    ``texnumber`` where there are several images); ``red green blue`` as integers or as floats in 0..1; polygons (made a
    fan around the first corner); images by ``comment TextureFile NAME``, else one of the same stem beside the file.

    Raises
    ------
    FrameError : the file is unreadable, malformed or cut off, has no vertices or faces, an index is out of range, an
        image path leads outside ``folder``, or an image that it names is not there
    """
    data = read_regular_file(path)
    try:
        elements, order, texture_names, body = _header(data)
        tables = _ascii_tables(data[body:], elements) if order == "" else _binary_tables(data, body, elements, order)
        vertices, vertex_uv, colors = _vertices(tables)
        faces, corner_uv, texture_number = _faces(tables, len(vertices))
    except _BadPly as bad:
        raise FrameError(path, str(bad), "export the frame again") from None
    if corner_uv is not None:
        uv, missing = corner_uv
        face_uv = np.where(missing[:, None], -1, np.arange(3 * len(faces)).reshape(-1, 3)).astype(np.int32)
    elif vertex_uv is not None:
        uv, face_uv = vertex_uv, faces.copy()
    else:
        uv, face_uv = np.zeros((0, 2)), np.full(faces.shape, -1, np.int32)
    images = _images(path, capture_roots(path, folder), texture_names)
    face_image = np.full(len(faces), -1 if not images else 0, np.int32)
    if texture_number is not None and len(images) > 1:
        face_image = np.where((texture_number >= 0) & (texture_number < len(images)), texture_number, -1).astype(
            np.int32
        )
    textures = tuple(Texture(image) for image in images)
    return RawMesh(vertices, faces, uv, face_uv, colors, textures, face_image, (path, *images))


def _images(path: Path, roots: tuple[Path, ...], names: list[str]) -> tuple[Path, ...]:
    if not names:
        beside = find_beside(path, SUFFIXES, roots)
        return () if beside is None else (beside,)
    images = []
    for name in names:
        image = find_named(name, path, roots)
        if image is None:
            raise FrameError(path, f'its texture "{name}" is not there', "put the image beside the mesh")
        images.append(image)
    return tuple(images)


def _header(data: bytes) -> tuple[list[_Element], str, list[str], int]:
    """Elements, byte order ("" for ASCII), image names and where the body begins."""
    end = data.find(b"end_header", 0, _LONGEST_HEADER)
    newline = data.find(b"\n", end, end + 16)
    if not data.startswith(b"ply") or end < 0 or newline < 0:
        raise _BadPly("it is not a PLY file")
    elements: list[_Element] = []
    order, textures = None, []
    for line in decode_text(data[:end]).splitlines()[1:]:
        words = line.split()
        if not words:
            continue
        try:
            if words[0] == "format":
                order = _ORDERS[words[1]]
            elif words[0] == "element":
                elements.append(_Element(words[1], int(words[2]), []))
                if elements[-1].count < 0:
                    raise ValueError
            elif words[0] == "property" and words[1] == "list":
                elements[-1].properties.append(_Property(words[4], _TYPES[words[3]], _TYPES[words[2]]))
            elif words[0] == "property":
                elements[-1].properties.append(_Property(words[2], _TYPES[words[1]]))
            elif words[0] == "comment" and len(words) > 2 and words[1].lower() == "texturefile":
                textures.append(line.split(None, 2)[2].strip())
        except (IndexError, KeyError, ValueError):
            raise _BadPly(f'its header line "{line.strip()[:60]}" cannot be understood') from None
    if order is None:
        raise _BadPly("its header does not state a format")
    for element in elements:
        names = [item.name for item in element.properties]
        if element.count > 0 and not names:
            raise _BadPly(f'its header gives "{element.name}" no properties')
        if len(set(names)) < len(names):
            raise _BadPly(f'its header names a property of "{element.name}" twice')
    return elements, order, textures, newline + 1


# A table: property name to an array of one value a row, or, for lists, to (lengths, all values joined).
_Table = dict[str, np.ndarray | tuple[np.ndarray, np.ndarray]]


def _binary_tables(data: bytes, at: int, elements: list[_Element], order: str) -> dict[str, _Table]:
    tables: dict[str, _Table] = {}
    for element in elements:
        tables[element.name], at = _binary_table(data, at, element, order)
    return tables


def _binary_table(data: bytes, at: int, element: _Element, order: str) -> tuple[_Table, int]:
    """Rows whose lists are all as long as the first row's are read as one array, others one by one."""
    lengths = _list_lengths(data, at, element, order) if element.count else {}
    fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
    for item in element.properties:
        if item.count_kind:
            fields.append((f"{item.name} count", order + item.count_kind))
            fields.append((item.name, order + item.kind, (lengths.get(item.name, 0),)))
        else:
            fields.append((item.name, order + item.kind))
    row = np.dtype(fields)
    if row.itemsize * element.count <= len(data) - at:
        rows = np.frombuffer(data, row, element.count, at)
        if all((rows[f"{name} count"] == length).all() for name, length in lengths.items()):
            table: _Table = {}
            for item in element.properties:
                values = rows[item.name]
                table[item.name] = (
                    (np.full(element.count, lengths.get(item.name, 0)), values.reshape(-1))
                    if item.count_kind
                    else values
                )
            return table, at + row.itemsize * element.count
    if not lengths:
        raise _BadPly(f'it is cut off in "{element.name}"')
    return _binary_rows(data, at, element, order)


def _list_lengths(data: bytes, at: int, element: _Element, order: str) -> dict[str, int]:
    lengths = {}
    for item in element.properties:
        if item.count_kind:
            length = int(_take(data, at, order + item.count_kind, 1, element)[0])
            at += np.dtype(item.count_kind).itemsize
            if length < 0:
                raise _BadPly(f'it holds a list of negative length in "{element.name}"')
            lengths[item.name] = length
            at += length * np.dtype(item.kind).itemsize
        else:
            at += np.dtype(item.kind).itemsize
    return lengths


def _binary_rows(data: bytes, at: int, element: _Element, order: str) -> tuple[_Table, int]:
    columns: dict[str, list[np.ndarray]] = {item.name: [] for item in element.properties}
    counts: dict[str, list[int]] = {item.name: [] for item in element.properties}
    for _ in range(element.count):
        for item in element.properties:
            length = 1
            if item.count_kind:
                length = int(_take(data, at, order + item.count_kind, 1, element)[0])
                at += np.dtype(item.count_kind).itemsize
                counts[item.name].append(length)
            columns[item.name].append(_take(data, at, order + item.kind, length, element))
            at += length * np.dtype(item.kind).itemsize
    table: _Table = {}
    for item in element.properties:
        values = np.concatenate(columns[item.name])
        table[item.name] = (np.array(counts[item.name]), values) if item.count_kind else values
    return table, at


def _take(data: bytes, at: int, kind: str, count: int, element: _Element) -> np.ndarray:
    if count < 0 or count * np.dtype(kind).itemsize > len(data) - at:
        raise _BadPly(f'it is cut off in "{element.name}"')
    return np.frombuffer(data, kind, count, at)


def _ascii_tables(text: bytes, elements: list[_Element]) -> dict[str, _Table]:
    try:
        numbers = np.array(text.split(), dtype=np.bytes_).astype(np.float64)
    except ValueError:
        raise _BadPly("it holds a word where a number belongs") from None
    tables: dict[str, _Table] = {}
    at = 0
    for element in elements:
        tables[element.name], at = _ascii_table(numbers, at, element)
    return tables


def _ascii_table(numbers: np.ndarray, at: int, element: _Element) -> tuple[_Table, int]:
    """As _binary_table: one array where all rows are alike, else row by row."""
    widths = []
    stop = at
    for item in element.properties:
        if item.count_kind:
            length = _ascii_length(numbers, stop, element) if element.count else 0
            widths.append(1 + length)
        else:
            widths.append(1)
        stop += widths[-1]
    starts = np.concatenate([[0], np.cumsum(widths)]).astype(int)
    width = int(starts[-1])
    if width * element.count <= len(numbers) - at:
        rows = numbers[at : at + width * element.count].reshape(element.count, width)
        listed = [
            (start, size)
            for item, start, size in zip(element.properties, starts, widths, strict=False)
            if item.count_kind
        ]
        if all((rows[:, start] == size - 1).all() for start, size in listed):
            table: _Table = {}
            for item, start, size in zip(element.properties, starts, widths, strict=False):
                values = rows[:, start + 1 : start + size].reshape(-1)
                table[item.name] = (np.full(element.count, size - 1), values) if item.count_kind else rows[:, start]
            return table, at + width * element.count
    if not any(item.count_kind for item in element.properties):
        raise _BadPly(f'it is cut off in "{element.name}"')
    columns: dict[str, list[np.ndarray]] = {item.name: [] for item in element.properties}
    counts: dict[str, list[int]] = {item.name: [] for item in element.properties}
    for _ in range(element.count):
        for item in element.properties:
            length = 1
            if item.count_kind:
                length = _ascii_length(numbers, at, element)
                counts[item.name].append(length)
                at += 1
            if at + length > len(numbers):
                raise _BadPly(f'it is cut off in "{element.name}"')
            columns[item.name].append(numbers[at : at + length])
            at += length
    table = {}
    for item in element.properties:
        values = np.concatenate(columns[item.name])
        table[item.name] = (np.array(counts[item.name]), values) if item.count_kind else values
    return table, at


def _ascii_length(numbers: np.ndarray, at: int, element: _Element) -> int:
    if at >= len(numbers):
        raise _BadPly(f'it is cut off in "{element.name}"')
    length = numbers[at]
    if not 0 <= length <= len(numbers) - at - 1 or length != int(length):
        raise _BadPly(f'it is cut off in "{element.name}"')
    return int(length)


def _scalar(table: _Table, name: str) -> np.ndarray | None:
    values = table.get(name)
    return None if isinstance(values, tuple) else values


def _vertices(tables: dict[str, _Table]) -> tuple[np.ndarray, np.ndarray | None, np.ndarray | None]:
    table = tables.get("vertex", {})
    position = [_scalar(table, name) for name in "xyz"]
    present = [values for values in position if values is not None]
    if len(present) < 3 or len(present[0]) == 0:
        raise _BadPly("it holds no vertices")
    uv = None
    for names in _UV_NAMES:
        pair = [values for values in (_scalar(table, name) for name in names) if values is not None]
        if len(pair) == 2:
            with np.errstate(invalid="ignore"):
                uv = np.stack(pair, axis=1).astype(np.float64)
            break
    colors = None
    channels = [values for values in (_scalar(table, name) for name in ("red", "green", "blue")) if values is not None]
    if len(channels) == 3:
        colors = _colors(np.stack(channels, axis=1))
    with np.errstate(invalid="ignore"):  # signalling NaNs: refused with the others, in frame_reader
        return np.stack(present, axis=1).astype(np.float64), uv, colors


def _colors(raw: np.ndarray) -> np.ndarray:
    """To bytes: floats up to 1 are shares of 255, 16-bit integers are halved in depth, others are taken as they are."""
    values = np.nan_to_num(raw.astype(np.float64))
    largest = values.max(initial=0.0)
    if raw.dtype.kind == "f" and largest <= 1.0 and (values % 1 != 0).any():
        values = values * 255.0
    elif largest > 255:
        values = values / 257.0
    return np.rint(np.clip(values, 0, 255)).astype(np.uint8)


def _faces(
    tables: dict[str, _Table], vertex_count: int
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray] | None, np.ndarray | None]:
    """Triangles, their corners' uv (as _corner_uv) and their image's number, the last two where the file has them."""
    table = tables.get("face", {})
    listed = table.get("vertex_indices", table.get("vertex_index"))
    if not isinstance(listed, tuple) or len(listed[0]) == 0:
        raise _BadPly("it holds triangle strips in place of faces" if "tristrips" in tables else "it holds no faces")
    corner_counts, corners = listed
    if (corner_counts < 3).any():
        raise _BadPly(f"face {int(np.argmax(corner_counts < 3))} has fewer than three corners")
    with np.errstate(invalid="ignore"):
        wrong = ~((corners >= 0) & (corners < vertex_count))
    if wrong.any():
        raise _BadPly(f"a face names vertex {corners[np.argmax(wrong)]:.0f}, but there are {vertex_count}")
    # the fan of a polygon that begins at `first`: (first, first + i, first + i + 1), i = 1 .. corners - 2
    first = np.cumsum(corner_counts) - corner_counts
    fans = corner_counts - 2
    polygon = np.repeat(np.arange(len(fans)), fans)
    step = np.arange(len(polygon)) - np.repeat(np.cumsum(fans) - fans, fans) + 1
    at = np.stack([first[polygon], first[polygon] + step, first[polygon] + step + 1], axis=1)
    faces = corners[at].astype(np.int32)
    uv = None
    wedges = table.get("texcoord")
    if isinstance(wedges, tuple) and wedges[0].any():
        wedge_counts, values = wedges
        uv = _corner_uv(wedge_counts, values, corner_counts, polygon, at - first[polygon][:, None])
    number = _scalar(table, "texnumber")
    return faces, uv, None if number is None else number[polygon].astype(np.int64)


def _corner_uv(
    wedge_counts: np.ndarray, values: np.ndarray, corner_counts: np.ndarray, polygon: np.ndarray, corner: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """``(3 m, 2)`` uv of every triangle's corners; and ``(m,) bool``, which triangles have none, their face's list
    being empty.
    """
    if not ((wedge_counts == 2 * corner_counts) | (wedge_counts == 0)).all():
        raise _BadPly("a face's list of texture coordinates does not fit its corners")
    start = (np.cumsum(wedge_counts) - wedge_counts)[polygon]
    padded = np.concatenate([values.astype(np.float64), [0.0, 0.0]])
    missing = wedge_counts[polygon] == 0
    at = np.where(missing[:, None], len(values), start[:, None] + 2 * corner)
    return np.stack([padded[at], padded[at + 1]], axis=2).reshape(-1, 2), missing
