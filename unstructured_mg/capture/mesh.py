"""One captured frame."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Texture:
    """A texture image on disk, decoded only where pixels are needed."""

    path: Path

    def read_bytes(self) -> bytes:
        """The file as it is, for exports that must not touch it."""
        return self.path.read_bytes()

    def pixels(self) -> np.ndarray:
        """Decode to ``(height, width, 3) uint8``, sRGB, top row first; grey, alpha, 16-bit and CMYK converted."""
        from unstructured_mg.capture.image import read_image

        return read_image(self.path)


@dataclass(frozen=True)
class TexturedMesh:
    """A triangle mesh with its texture, in metres, z up, floor at z = 0.

    A seam of the atlas is one vertex with two uvs: ``faces`` index ``vertices``, ``face_uv`` index ``uv``.

    Attributes
    ----------
    vertices : (n, 3) float64, metres
    faces : (m, 3) int32
    uv : (q, 2) float64, v upwards as in OBJ; (0, 2) where there is none
    face_uv : (m, 3) int32; (0, 3) where there is no uv
    colors : (n, 3) uint8, sRGB, or None
    textures : one handle a material; empty where there is none
    face_material : (m,) int32 index into ``textures``, or None where there is at most one
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    face_uv: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), np.int32))
    colors: np.ndarray | None = None
    textures: tuple[Texture, ...] = ()
    face_material: np.ndarray | None = None
