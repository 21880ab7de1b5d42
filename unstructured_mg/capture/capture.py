"""A capture: ordered clips of textured meshes, read on demand."""

from dataclasses import asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.capture.frame_file import FrameFile
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.capture.placement import UP_AXES
from unstructured_mg.errors import FrameFault, UserError


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

    @cached_property
    def clips(self) -> tuple[str, ...]:
        """Names of the clips, in playing order; also of those in which no frame is good."""
        return tuple(dict.fromkeys([frame.clip for frame in self.frames] + [fault.clip for fault in self.faults]))

    def id_of(self, clip: str, number: int) -> str:
        """The id of a frame, good or bad."""
        return str(number) if len(self.clips) == 1 else f"{clip}:{number}"

    def frame_id(self, index: int) -> str:
        frame = self.frames[index]
        return self.id_of(frame.clip, frame.number)

    def index_of(self, frame_id: str) -> int:
        """The index of the good frame of that id. Zero padding is accepted. Raises UserError where there is none."""
        clip, _, number = frame_id.rpartition(":")
        try:
            return self._index[clip or self.clips[0] if len(self.clips) == 1 else clip, int(number)]
        except (KeyError, ValueError):
            first, last = self.frame_id(0), self.frame_id(len(self) - 1)
            raise UserError(
                f'{self.folder}: there is no usable frame "{frame_id}"; frames are named from {first} to {last}.'
            ) from None

    @cached_property
    def _index(self) -> dict[tuple[str, int], int]:
        return {(frame.clip, frame.number): i for i, frame in enumerate(self.frames)}

    def to_metres(self) -> np.ndarray:
        """The (4, 4) float64 similarity, on column vectors, from capture coordinates to metres, z up, floor 0."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.unit * np.array(UP_AXES[self.up], dtype=np.float64)
        matrix[2, 3] = -self.unit * self.floor
        return matrix

    def runs(self) -> list[range]:
        """Maximal ranges of frame indices that follow each other without a gap inside one clip."""
        starts = [
            i
            for i, frame in enumerate(self.frames)
            if i == 0 or (self.frames[i - 1].clip, self.frames[i - 1].number + 1) != (frame.clip, frame.number)
        ]
        return [range(start, stop) for start, stop in zip(starts, [*starts[1:], len(self)], strict=True)]

    def window_centres(self, k: int) -> np.ndarray:
        """``(len(self),) bool``: where a whole window of ``2 k + 1`` frames fits into the frame's run."""
        centres = np.zeros(len(self), bool)
        for run in self.runs():
            centres[run.start + k : max(run.stop - k, run.start)] = True
        return centres

    def read(self, index: int) -> TexturedMesh:
        """Read frame ``index`` in metres, z up, floor at 0. Raises UserError where the file went bad since."""
        from unstructured_mg.capture.frame_reader import read_frame

        mesh, _, _ = read_frame(self.frames[index], self.folder)
        matrix = self.to_metres()
        return replace(mesh, vertices=mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3])

    def to_json(self) -> dict[str, Any]:
        """The capture without its meshes, JSON-ready; paths of frames are relative to the folder, with forward
        slashes.
        """
        return {
            "folder": str(self.folder),
            "fps": self.fps,
            "unit": self.unit,
            "up": self.up,
            "floor": self.floor,
            "frames": [
                {
                    "id": self.frame_id(i),
                    "clip": frame.clip,
                    "number": frame.number,
                    "file": frame.path.relative_to(self.folder).as_posix(),
                    "sha256": frame.sha256,
                    **({} if frame.part is None else {"part": frame.part, "format": frame.format}),
                }
                for i, frame in enumerate(self.frames)
            ],
            "faults": [asdict(fault) for fault in self.faults],
            "warnings": list(self.warnings),
        }

    @staticmethod
    def from_json(data: dict[str, Any]) -> "Capture":
        """The inverse of to_json."""
        folder = Path(data["folder"])
        return Capture(
            folder=folder,
            frames=tuple(
                FrameFile(
                    frame["clip"],
                    frame["number"],
                    folder / frame["file"],
                    frame["sha256"],
                    frame.get("part"),
                    frame.get("format", ""),
                )
                for frame in data["frames"]
            ),
            fps=data["fps"],
            unit=data["unit"],
            up=data["up"],
            floor=data["floor"],
            faults=tuple(FrameFault(**fault) for fault in data["faults"]),
            warnings=tuple(data["warnings"]),
        )


def frame_hash(capture: Capture, index: int) -> str:
    """Hexadecimal SHA-256 over all files that frame ``index`` is made of, as they were when the capture was opened."""
    return capture.frames[index].sha256
