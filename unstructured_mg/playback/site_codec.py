"""The binary form of a web page's frames (docs/files.md, "A web page"): columns of differences, deflated, in a script.

A page opened from a disk may read nothing but scripts, so each file is one: a call with the data as its only string.
"""

import json
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

# What cannot stand in a script's string as it is; NUL may, but not everybody knows.
_ESCAPES = ((b"\\", b"\\\\"), (b'"', b'\\"'), (b"\n", b"\\n"), (b"\r", b"\\r"), (b"\0", b"\\x00"))


def column(values: np.ndarray) -> bytes:
    """Whole numbers (n,) uint8, uint16 or uint32 as differences: of the first from 0, of each from the one before.

    Differences are taken modulo the type's size, zigzagged (0, -1, 1, -2, ... become 0, 1, 2, 3, ...), and their bytes
    written plane by plane: all lowest bytes first, then all next ones.
    """
    signed = values.dtype.str.replace("u", "i")
    with np.errstate(over="ignore"):
        steps = np.diff(values, prepend=values.dtype.type(0)).view(signed)
        folded = ((steps << 1) ^ (steps >> (8 * values.itemsize - 1))).astype(values.dtype.newbyteorder("<"))
    return np.ascontiguousarray(folded).view(np.uint8).reshape(-1, values.itemsize).T.tobytes()


def columns(values: np.ndarray) -> bytes:
    """`column` of each column of (n, c) values, one after the other."""
    return b"".join(column(np.ascontiguousarray(values[:, index])) for index in range(values.shape[1]))


def script(name: str, header: Mapping[str, Any], sections: Sequence[bytes]) -> bytes:
    """The file ``NAME.js``: ``umg.take("NAME","...")`` around a deflated header and sections.

    Inside the zlib stream: the header's length (uint32, little-endian), the header as JSON, the sections. Outside:
    bytes are characters of windows-1252, with a backslash before what a script's string cannot hold.
    """
    text = json.dumps(header, separators=(",", ":"), allow_nan=False).encode()
    data = zlib.compress(b"".join([len(text).to_bytes(4, "little"), text, *sections]), 9)
    for raw, escaped in _ESCAPES:
        data = data.replace(raw, escaped)
    return f'umg.take("{name}","'.encode() + data + b'")\n'
