"""Stretches of bytes in files that hold more than one thing, read without reading the rest."""

import stat
from functools import lru_cache
from hashlib import file_digest
from pathlib import Path

from unstructured_mg.capture.frame_error import FrameError

#: No frame of a file of many may be larger than this.
LARGEST_STRETCH = 1 << 30


def file_stamp(path: Path) -> tuple[int, int]:
    """Size in bytes and time of the last change in nanoseconds: what is remembered of a file holds while this does.

    Raises FrameError where it is no regular file.
    """
    try:
        status = path.stat()
    except FileNotFoundError:
        raise FrameError(path, "there is no such file", "export the capture again") from None
    except OSError as error:
        raise FrameError(path, f"it cannot be read ({error.strerror})", "check the file's permissions") from None
    if not stat.S_ISREG(status.st_mode):
        raise FrameError(path, "it is not a regular file", "put a file in its place")
    return status.st_size, status.st_mtime_ns


def read_stretch(path: Path, start: int, size: int, what: str) -> bytes:
    """``size`` bytes of a file from byte ``start``, which are ``what``.

    Raises
    ------
    FrameError : the file ends before; names the byte at which it does. Nothing is read in that case
    """
    end, _ = file_stamp(path)
    if start < 0 or size < 0 or start + size > end:
        raise FrameError(
            path,
            f"it ends at byte {end}, where {what} should reach from byte {start} to byte {start + size}",
            "copy or export the file again",
        )
    if size > LARGEST_STRETCH:
        raise FrameError(
            path, f"{what} at byte {start} takes {size} bytes", "no frame may exceed 1 GiB: export it smaller"
        )
    try:
        with open(path, "rb") as file:
            file.seek(start)
            data = file.read(size)
    except OSError as error:
        raise FrameError(path, f"it cannot be read ({error.strerror})", "check the disk") from None
    if len(data) < size:
        raise FrameError(path, f"it became shorter than {start + size} bytes", "copy or export the file again")
    return data


def whole_digest(path: Path) -> bytes:
    """SHA-256 of a file of any size; worked out once a process while the file does not change."""
    return _digest(path, file_stamp(path))


@lru_cache(maxsize=64)
def _digest(path: Path, stamp: tuple[int, int]) -> bytes:
    try:
        with open(path, "rb") as file:
            return file_digest(file, "sha256").digest()
    except OSError as error:
        raise FrameError(path, f"it cannot be read ({error.strerror})", "check the file's permissions") from None
