"""What a mesh file says, before anything is mended: the readers' common result."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from unstructured_mg.capture.texture import Texture


@dataclass(frozen=True)
class RawMesh:
    """A triangulated mesh file. All indices are in range; values may still be anything.

    Attributes
    ----------
    vertices : (n, 3) float64, in the file's unit and axis
    faces : (m, 3) int32, at least one
    uv : (q, 2) float64, v upwards
    face_uv : (m, 3) int32 into ``uv``, -1 where a corner has none
    colors : (n, 3) uint8, or None
    images : the texture images in use
    face_image : (m,) int32 index into ``images``, -1 where a face has none
    files : every file that was read to get here, the mesh file first, images last
    stretches : (start, size) of the bytes of the first file that are this frame's, where it holds others as well; all
        of it where empty
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    face_uv: np.ndarray
    colors: np.ndarray | None = None
    images: tuple[Texture, ...] = ()
    face_image: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))
    files: tuple[Path, ...] = ()
    stretches: tuple[tuple[int, int], ...] = ()
