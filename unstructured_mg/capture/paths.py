"""Paths written inside a capture's files, resolved without ever leaving the capture."""

import re
import stat
from pathlib import Path, PurePosixPath

from unstructured_mg.capture.frame_error import FrameError

#: One frame's mesh file may not be larger than this.
LARGEST_FILE = 1 << 28


def capture_roots(path: Path, folder: Path) -> tuple[Path, ...]:
    """The folders that the frame at ``path`` may name files in: the capture's, and, where the frame is a symbolic link
    that its owner put there, the one it really lies in."""
    return folder.resolve(), path.resolve().parent


def find_named(name: str, written_in: Path, roots: tuple[Path, ...]) -> Path | None:
    """The file that ``name``, as the file ``written_in`` has it, means; None where there is none.

    Backslashes count as slashes, and where case is the only difference the file is found all the same.

    Raises
    ------
    FrameError : the path leads outside ``roots``, by ``..``, because it is absolute, or over a symbolic link
    """
    parts = PurePosixPath(name.replace("\\", "/"))
    drive = re.match(r"[A-Za-z]:", name) is not None
    path = written_in.parent / parts
    if drive or not _is_inside(path, roots):
        raise _outside(written_in, name)
    if _is_file(path):
        return path
    found = None if parts.is_absolute() else _ignoring_case(written_in.parent, parts)
    if found is not None and not _is_inside(found, roots):
        raise _outside(written_in, name)
    return found


def find_beside(path: Path, suffixes: tuple[str, ...], roots: tuple[Path, ...]) -> Path | None:
    """The first file of the same stem as ``path`` with one of ``suffixes``, whatever the case of its suffix.

    Raises FrameError where that is a symbolic link that leads outside ``roots``.
    """
    for suffix in suffixes:
        for spelt in (suffix, suffix.upper()):
            candidate = path.with_name(path.stem + spelt)
            if _is_file(candidate):
                if not _is_inside(candidate, roots):
                    raise _outside(path, candidate.name)
                return candidate
    return None


def read_regular_file(path: Path) -> bytes:
    """The bytes of a regular file of at most ``LARGEST_FILE`` bytes. Raises FrameError for anything else."""
    try:
        status = path.stat()
        if not stat.S_ISREG(status.st_mode):
            raise FrameError(path, "it is not a regular file", "put a file in its place")
        if status.st_size == 0:
            raise FrameError(path, "the file is empty", "export the frame again")
        if status.st_size > LARGEST_FILE:
            raise FrameError(
                path, f"the file has {status.st_size} bytes", "no frame may exceed 256 MiB: export it smaller"
            )
        return path.read_bytes()
    except FileNotFoundError:
        raise FrameError(path, "there is no such file", "export the frame again") from None
    except OSError as error:
        raise FrameError(
            path, f"it cannot be read ({error.strerror})", "check the file's permissions and the disk"
        ) from None


def decode_text(text: bytes) -> str:
    """Names in UTF-8, or in the Latin-1 of older exporters where it is not UTF-8."""
    try:
        return text.decode("utf-8")
    except UnicodeDecodeError:
        return text.decode("latin-1")


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a folder that may not be looked into, a name longer than any file's
        return False


def _is_inside(path: Path, roots: tuple[Path, ...]) -> bool:
    try:
        resolved = path.resolve()
    except (OSError, RuntimeError, ValueError):  # a loop of links, a name with a zero byte
        return False
    return any(resolved.is_relative_to(root) for root in roots)


def _outside(written_in: Path, name: str) -> FrameError:
    return FrameError(
        written_in,
        f'the path "{name}" leads outside the capture folder',
        "move that file into the folder and name it there",
    )


def _ignoring_case(folder: Path, parts: PurePosixPath) -> Path | None:
    path = folder
    for part in parts.parts:
        try:
            if part == ".." or (path / part).exists():
                path = path / part
                continue
            matches = sorted(entry.name for entry in path.iterdir() if entry.name.lower() == part.lower())
        except OSError:
            return None
        if not matches:
            return None
        path = path / matches[0]
    return path if _is_file(path) else None
