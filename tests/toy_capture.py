"""A capture without files, for tests of the rooms that only need its frames' names, order and meshes."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from unstructured_mg.capture.capture import Capture, FrameFile
from unstructured_mg.capture.mesh import TexturedMesh


@dataclass(frozen=True)
class ToyCapture(Capture):
    """``mesh_of`` gives frame ``index`` in metres, z up."""

    mesh_of: Callable[[int], TexturedMesh] | None = None

    def frame_id(self, index: int) -> str:
        frame = self.frames[index]
        return f"{frame.clip}:{frame.number}" if len({f.clip for f in self.frames}) > 1 else str(frame.number)

    def index_of(self, frame_id: str) -> int:
        return [self.frame_id(index) for index in range(len(self))].index(frame_id)

    def to_metres(self) -> np.ndarray:
        turn = {"z": np.eye(3), "y": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])}[self.up]
        matrix = np.eye(4)
        matrix[:3, :3] = self.unit * turn
        matrix[2, 3] = -self.unit * self.floor
        return matrix

    def runs(self) -> list[range]:
        runs: list[range] = []
        for index, frame in enumerate(self.frames):
            before = self.frames[index - 1] if index else None
            if before is not None and (before.clip, before.number + 1) == (frame.clip, frame.number):
                runs[-1] = range(runs[-1].start, index + 1)
            else:
                runs.append(range(index, index + 1))
        return runs

    def read(self, index: int) -> TexturedMesh:
        assert self.mesh_of is not None
        return self.mesh_of(index)


def toy_capture(
    *run_lengths: int,
    clips: bool = False,
    mesh_of: Callable[[int], TexturedMesh] | None = None,
    unit: float = 1.0,
    up: str = "z",
    floor: float = 0.0,
) -> ToyCapture:
    """Runs of the given lengths: numbered from 1 with a gap after each, or each a clip "a", "b", ... of its own."""
    frames, number = [], 1
    for run, length in enumerate(run_lengths):
        clip = chr(ord("a") + run) if clips else ""
        for _ in range(length):
            frames.append(FrameFile(clip, number, Path(f"{clip}{number}.obj")))
            number += 1
        number = 1 if clips else number + 5
    return ToyCapture(Path("toy"), tuple(frames), 30.0, unit, up, floor, mesh_of=mesh_of)
