"""A capture whose frames live in memory, for tests of what comes after reading."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from toy_capture import ToyCapture

from unstructured_mg.capture.capture import FrameFile
from unstructured_mg.capture.mesh import TexturedMesh


def memory_capture(names: Sequence[tuple[str, int]], meshes: Sequence[TexturedMesh] = (), **rest: object) -> ToyCapture:
    """A capture of frames with the given (clip, number)."""
    frames = tuple(FrameFile(clip, number, Path(f"{clip}/frame_{number}.obj")) for clip, number in names)
    return ToyCapture(Path("capture"), frames, 30.0, 1.0, "y", 0.0, mesh_of=tuple(meshes).__getitem__, **rest)


def box(
    colour: tuple[int, int, int], size: Sequence[float] = (0.4, 0.3, 1.8), at: Sequence[float] = (0, 0, 0)
) -> TexturedMesh:
    """A box in one vertex colour that stands on the floor at ``at``."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])
    faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
    ]
    faces += [[1, 5, 7], [1, 7, 3]]
    return TexturedMesh(corners * size + at, np.array(faces, np.int32), colors=np.full((8, 3), colour, np.uint8))
