"""A capture without files, for tests of the rooms that only need its frames' names, order and meshes."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from unstructured_mg.capture.capture import Capture, FrameFile
from unstructured_mg.capture.mesh import TexturedMesh


@dataclass(frozen=True)
class ToyCapture(Capture):
    """``mesh_of`` gives frame ``index`` in metres, z up."""

    mesh_of: Callable[[int], TexturedMesh] | None = None

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
