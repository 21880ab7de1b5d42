"""The colour of every face of a frame."""

import numpy as np

from unstructured_mg.capture.mesh import TexturedMesh

# Where a face is looked up, as weights of its corners: its centre, and half way to each corner.
_PLACES = np.array([[1, 1, 1], [4, 1, 1], [1, 4, 1], [1, 1, 4]]) / np.array([[3], [6], [6], [6]])


def has_colours(mesh: TexturedMesh) -> bool:
    return bool(mesh.textures) or mesh.colors is not None


def face_colours(mesh: TexturedMesh) -> np.ndarray:
    """``(m, 3) float32`` in 0..1, sRGB: the mean of four texels of each face, or of its vertices' colours.

    A ValueError where the mesh has neither.
    """
    if mesh.textures:
        places = np.einsum("pc,fcd->fpd", _PLACES, mesh.uv[mesh.face_uv])
        colours = np.empty((len(mesh.faces), 3), np.float32)
        material = np.zeros(len(mesh.faces), np.int32) if mesh.face_material is None else mesh.face_material
        for number, texture in enumerate(mesh.textures):
            pixels = texture.pixels()
            height, width = pixels.shape[:2]
            at = places[material == number]
            column = np.floor(at[..., 0] * width).astype(np.intp) % width
            row = np.floor((1 - at[..., 1]) * height).astype(np.intp) % height
            colours[material == number] = pixels[row, column].mean(axis=1, dtype=np.float32) / 255
        return colours
    if mesh.colors is None:
        raise ValueError("mesh: expected textures or vertex colours, got neither")
    return mesh.colors[mesh.faces].mean(axis=1, dtype=np.float32) / np.float32(255)
