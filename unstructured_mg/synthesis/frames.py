"""Captured frames as synthesis reads them."""

from typing import Protocol

from unstructured_mg.capture.mesh import TexturedMesh


class Frames(Protocol):
    """What synthesis needs of a capture."""

    def read(self, index: int) -> TexturedMesh:
        """As ``Capture.read``."""


class KeptFrames:
    """Reads each frame once: both directions and their textures need the windows' ends."""

    def __init__(self, frames: Frames):
        self._source = frames
        self._kept: dict[int, TexturedMesh] = {}

    def read(self, index: int) -> TexturedMesh:
        """As ``Capture.read``."""
        if index not in self._kept:
            self._kept[index] = self._source.read(index)
        return self._kept[index]
