"""A transition's texture for players: two end textures, and the flow that warps one into the other in a shader."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.geometry.laplacian import face_areas
from unstructured_mg.geometry.triangles import TriangleElements


@dataclass(frozen=True)
class TextureFlow:
    """Textures of steps -k and k on the transition's template, and the flow v from the first to the second.

    The texture at l = (step + k) / 2k is about ``(1 - l) first(uv - l uv_flow) + l last(uv + (1 - l) uv_flow)``.

    Attributes
    ----------
    reference : (n, 3) float32, metres: the shape that the flow lies on, the template in its own frame
    displacement : (n, 3) float32, metres on ``reference``: v, tangent to it, at every vertex
    uv_flow : (q, 2) float32: the same as a change of the atlas's uv, at every uv; empty without images
    textures : the two encoded images; empty without images
    texture_suffix : ".jpg", empty without images
    colors : (2, n, 3) uint8 in place of the images where the capture has vertex colours, else None
    """

    reference: np.ndarray
    displacement: np.ndarray
    uv_flow: np.ndarray
    textures: tuple[bytes, ...]
    texture_suffix: str
    colors: np.ndarray | None


def uv_changes(
    vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray, face_uv: np.ndarray, displacement: np.ndarray
) -> np.ndarray:
    """How far ``(q, 2) float64`` each uv moves when its surface point moves by a tangent displacement.

    The displacement d at a face's corner changes its place in the atlas by (grad uv) d. A uv takes the mean of its
    faces by area, so that the change is continuous inside charts.

    vertices (n, 3), faces (m, 3), uv (q, 2), face_uv (m, 3), displacement (n, 3) in the vertices' unit.
    """
    elements = TriangleElements(vertices, faces)
    slopes = np.einsum("fia,fib->fab", uv[face_uv], elements.gradients)
    areas = face_areas(vertices, faces)
    moves = areas[:, None, None] * np.einsum("fab,fib->fia", slopes, displacement[faces])
    total = np.bincount(face_uv.ravel(), np.repeat(areas, 3), minlength=len(uv))
    sums = np.stack([np.bincount(face_uv.ravel(), moves[:, :, i].ravel(), minlength=len(uv)) for i in (0, 1)], axis=1)
    return np.divide(sums, total[:, None], out=np.zeros_like(sums), where=total[:, None] > 0)
