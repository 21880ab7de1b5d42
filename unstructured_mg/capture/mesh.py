"""One captured frame."""

from dataclasses import dataclass, field

import numpy as np

from unstructured_mg.capture.texture import Texture


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
