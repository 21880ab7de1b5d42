"""Texture images to pixels."""

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from PIL import Image

from unstructured_mg.capture.frame_error import FrameError

#: What may be a texture. Pillow is asked for these only: some of its other readers start outside programs.
FORMATS = ("JPEG", "PNG", "WEBP", "TIFF", "TGA", "BMP")
SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".tga", ".bmp")
#: Larger images are refused before a pixel of them is decoded: 8192 x 8192 passes.
MOST_PIXELS = 1 << 26


def read_image(path: Path, data: bytes | None = None) -> np.ndarray:
    """Decode to ``(height, width, 3) uint8``, sRGB, top row first: the file, or ``data`` out of it.

    Grey is repeated, alpha dropped (not blended), 16-bit values scaled to 8, CMYK and palettes converted; of an
    animation the first frame counts.

    Raises
    ------
    UserError : the file is not there, not an image of ``FORMATS``, damaged, or has more than ``MOST_PIXELS`` pixels
    """
    with _opened(path, data) as image:
        if image.mode == "F" or image.mode.startswith("I"):
            # 16-bit grey: Pillow's own conversion would clip at 255
            deep = np.asarray(image)
            grey = np.clip(deep, 0, 65535) // 257 if deep.dtype.kind in "iu" else np.clip(deep, 0, 1) * 255
            return np.repeat(grey.astype(np.uint8)[:, :, None], 3, axis=2)
        if image.mode == "P":
            image = image.convert("RGBA" if "transparency" in image.info else "RGB")
        return np.array(image.convert("RGB"))


def check_image(path: Path, data: bytes | None = None) -> tuple[int, int]:
    """``(width, height)`` of an image that decodes without error; faster than decoding it. Raises UserError as
    read_image.
    """
    with _opened(path, data) as image:
        size = image.size
        if image.format == "PNG":
            image.verify()
        else:
            if image.format == "JPEG":
                image.draft("RGB", (1, 1))  # all of the stream is parsed, but only an eighth of the pixels computed
            image.load()
    return size


def image_size(path: Path, data: bytes | None = None) -> tuple[int, int]:
    """``(width, height)`` as the image's header has it. Raises UserError as read_image, but damaged pixels go
    unnoticed.
    """
    with _opened(path, data) as image:
        return image.size


@contextmanager
def _opened(path: Path, data: bytes | None) -> Iterator[Image.Image]:
    remedy = "export the texture again as PNG or JPEG"
    try:
        # what Pillow only warns of (odd metadata) does not matter here, or is refused below
        source = path if data is None else io.BytesIO(data)
        with warnings.catch_warnings(action="ignore"), Image.open(source, formats=FORMATS) as image:
            width, height = image.size
            if width * height > MOST_PIXELS:
                raise FrameError(
                    path, f"the image has {width} x {height} pixels", "no texture may exceed 8192 x 8192: scale it"
                )
            yield image
    except Image.DecompressionBombError:
        raise FrameError(path, "the image has too many pixels", "no texture may exceed 8192 x 8192: scale it") from None
    except FileNotFoundError:
        raise FrameError(path, "there is no such image", remedy) from None
    except PermissionError:
        raise FrameError(path, "the image cannot be read", "check the file's permissions") from None
    except (OSError, SyntaxError, ValueError, EOFError, MemoryError, IndexError, OverflowError) as error:
        # the kinds of error Pillow's decoders raise on damaged files
        reason = str(error).replace(str(path), path.name) or type(error).__name__
        raise FrameError(path, f"the image cannot be decoded ({reason})", remedy) from None
