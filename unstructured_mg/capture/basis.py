"""Basis Universal textures (KTX2 and .basis) to pixels."""

import struct
from pathlib import Path

import numpy as np

from unstructured_mg.capture.frame_error import FrameError

MAGIC = b"\xabKTX 20\xbb\r\n\x1a\n"
_MOST_PIXELS = 1 << 26
_MOST_LAYERS = 1 << 16
_REMEDY = "copy or export the texture again"
_HEADER = struct.Struct("<9I4I2Q")


def read_basis(path: Path, start: int, data: bytes, layer: int) -> np.ndarray:
    """Decode layer ``layer`` of the texture ``data``, which stands at byte ``start`` of ``path``.

    ``(height, width, 3) uint8``, sRGB, top row first; alpha is dropped. A layer may build on those before it, so these
    are decoded as well, in order.

    Raises
    ------
    FrameError : not KTX2 or .basis, cut off, lying or damaged; names the byte and what was expected; the decoder is not
        installed
    """
    width, height, layers = check_basis(path, start, data)
    if layer >= layers:
        raise FrameError(path, f"its texture has {layers} layers, but the frame needs number {layer + 1}", _REMEDY)
    try:
        import opengl_basisu
    except ImportError:
        raise FrameError(path, "reading its texture needs a decoder", "pip install 'unstructured_mg[codecs]'") from None
    try:
        texture = opengl_basisu.open(data)
        for before in range(layer + 1):
            pixels = np.asarray(texture.transcode("rgba8", level=0, layer=before).data)
        if texture.y_flipped:
            pixels = pixels[::-1]
    except (ValueError, MemoryError) as error:
        what = f"bytes {start} to {start + len(data)}: expected a Basis Universal texture of {width} x {height} pixels"
        raise FrameError(path, f"{what} ({error})", _REMEDY) from None
    return np.ascontiguousarray(pixels.reshape(height, width, 4)[:, :, :3])


def check_basis(path: Path, start: int, data: bytes) -> tuple[int, int, int]:
    """Width, height and layers of a texture whose header promises nothing that ``data`` does not hold.

    Raises FrameError as ``read_basis``.
    """
    if data.startswith(b"sB"):
        return _check_basis_file(path, start, data)
    if not data.startswith(MAGIC):
        raise FrameError(path, f"byte {start}: expected a KTX2 texture, found {data[:12].hex(' ')}", _REMEDY)
    if len(data) < 12 + _HEADER.size:
        raise FrameError(
            path, f"it ends at byte {start + len(data)}, where the KTX2 header should reach to {start + 92}", _REMEDY
        )
    values = _HEADER.unpack_from(data, 12)
    _, _, width, height, depth, layers, faces, levels, _ = values[:9]
    for name, at, value, most in (
        ("a width", 20, width, _MOST_PIXELS),
        ("a height", 24, height, _MOST_PIXELS),
    ):
        if not 0 < value <= most:
            raise FrameError(path, f"byte {start + at}: expected {name} in pixels, found {value}", _REMEDY)
    if width * height > _MOST_PIXELS:
        raise FrameError(
            path, f"byte {start + 20}: its texture has {width} x {height} pixels", "no texture may exceed 8192 x 8192"
        )
    if depth > 0 or faces != 1:
        raise FrameError(
            path, f"byte {start + 28}: expected a flat texture, found depth {depth}, {faces} faces", _REMEDY
        )
    if layers > _MOST_LAYERS:
        raise FrameError(path, f"byte {start + 32}: expected a number of layers, found {layers}", _REMEDY)
    levels = max(levels, 1)
    if levels > 32 or 80 + 24 * levels > len(data):
        raise FrameError(path, f"byte {start + 40}: expected a number of levels, found {levels}", _REMEDY)
    stretches = [
        (48, values[9], values[10], "format"),
        (56, values[11], values[12], "keys"),
        (64, *values[13:], "codebook"),
    ]
    stretches += [(80 + 24 * i, *struct.unpack_from("<2Q", data, 80 + 24 * i), f"level {i}") for i in range(levels)]
    for at, offset, size, what in stretches:
        if offset + size > len(data):
            raise FrameError(
                path,
                f"byte {start + at}: the texture's {what} should reach to byte {start + offset + size}, "
                f"but it ends at byte {start + len(data)}",
                _REMEDY,
            )
    return width, height, max(layers, 1)


def _check_basis_file(path: Path, start: int, data: bytes) -> tuple[int, int, int]:
    try:
        import opengl_basisu
    except ImportError:
        raise FrameError(path, "reading its texture needs a decoder", "pip install 'unstructured_mg[codecs]'") from None
    try:
        texture = opengl_basisu.open(data)
    except (ValueError, MemoryError) as error:
        raise FrameError(path, f"byte {start}: expected a .basis texture ({error})", _REMEDY) from None
    if texture.width * texture.height > _MOST_PIXELS:
        raise FrameError(
            path,
            f"byte {start}: its texture has {texture.width} x {texture.height} pixels",
            "no texture may exceed 8192 x 8192",
        )
    return texture.width, texture.height, texture.layers
