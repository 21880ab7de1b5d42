"""Where one frame lies."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class FrameFile:
    """Where one good frame lies. ``number`` is the number in its file name, or the one that a file of many gives it.

    Where the file holds, or lists, many frames, ``part`` is its position among them, from 0, and ``format`` the file's
    ("vols", "gltf", "hcap", "uvol" or "scvv"); ``part`` is None for a frame with a file of its own.
    ``sha256`` is of all files the frame is made of (mesh, material library, images); empty until the frame was checked.
    """

    clip: str
    number: int
    path: Path
    sha256: str = ""
    part: int | None = None
    format: str = ""
