"""A capture: ordered clips of textured meshes, read on demand."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import FrameFault


@dataclass(frozen=True)
class FrameFile:
    """Where one good frame lies. ``number`` is the number in its file name."""

    clip: str
    number: int
    path: Path


@dataclass(frozen=True)
class Capture:
    """All good frames of a capture in playing order, with what is needed to bring them to metres, z up, floor 0.

    A frame is named by its index into ``frames`` inside the program and by its id (``clip:number``, or ``number`` where
    there is one clip) outside. Bad frames are in ``faults``, never in ``frames``, and leave a gap.
    The object is small and picklable: workers get it whole and read the frames they need.

    Attributes
    ----------
    folder : the capture's folder
    frames : good frames, clip by clip in natural order, by number inside a clip
    fps : frames a second
    unit : metres per capture unit
    up : the capture's up axis, "y" or "z" (or "-y", "-z", "x", "-x")
    floor : height of the floor along the up axis, in capture units
    faults : the frames that cannot be used
    warnings : what was assumed, a sentence each
    """

    folder: Path
    frames: tuple[FrameFile, ...]
    fps: float
    unit: float
    up: str
    floor: float
    faults: tuple[FrameFault, ...] = ()
    warnings: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.frames)

    def frame_id(self, index: int) -> str:
        raise NotImplementedError

    def index_of(self, frame_id: str) -> int:
        raise NotImplementedError

    def to_metres(self) -> np.ndarray:
        """The (4, 4) float64 similarity, on column vectors, from capture coordinates to metres, z up, floor 0."""
        raise NotImplementedError

    def runs(self) -> list[range]:
        """Maximal ranges of frame indices that follow each other without a gap inside one clip."""
        raise NotImplementedError

    def window_centres(self, k: int) -> np.ndarray:
        """``(len(self),) bool``: where a whole window of ``2 k + 1`` frames fits into the frame's run."""
        raise NotImplementedError

    def read(self, index: int) -> TexturedMesh:
        """Read frame ``index`` in metres, z up, floor at 0. Raises UserError where the file went bad since."""
        raise NotImplementedError
