"""Draco meshes to arrays."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from unstructured_mg.capture.frame_error import FrameError

_REMEDY = "copy or export the file again"


@dataclass(frozen=True)
class DracoMesh:
    """``vertices (n, 3) float64``, ``faces (m, 3) int32``, every attribute ``(n, k)`` by its id in the file, and
    the ids of the texture coordinates and of the colours, -1 where there are none.
    """

    vertices: np.ndarray
    faces: np.ndarray
    attributes: dict[int, np.ndarray]
    uv: int
    colors: int


def decode_draco(path: Path, start: int, data: bytes) -> DracoMesh:
    """Decode the Draco triangle mesh ``data``, which stands at byte ``start`` of ``path``.

    Raises
    ------
    FrameError : not Draco, no triangle mesh, cut off or damaged; names the byte and what was expected; the decoder is
        not installed
    """
    if len(data) < 11 or data[:5] != b"DRACO":
        raise FrameError(path, f"byte {start}: expected DRACO, found {data[:5].hex(' ')}", _REMEDY)
    if data[7] != 1:
        raise FrameError(path, f"byte {start + 7}: expected a triangle mesh (1), found {data[7]}", "export meshes")
    try:
        import DracoPy
    except ImportError:
        raise FrameError(path, "reading Draco needs a decoder", "pip install 'unstructured_mg[codecs]'") from None
    what = f"bytes {start} to {start + len(data)}: expected a Draco mesh"
    try:
        mesh = DracoPy.decode(data)
        vertices = np.asarray(mesh.points, np.float64).reshape(-1, 3)
        faces = np.asarray(mesh.faces, np.int64).reshape(-1, 3)
    except (DracoPy.FileTypeException, ValueError, TypeError, AttributeError, MemoryError) as error:
        raise FrameError(path, f"{what}, which cannot be decoded ({error})", _REMEDY) from None
    if len(vertices) == 0 or len(faces) == 0:
        raise FrameError(path, f"{what} with vertices and faces, found {len(vertices)} and {len(faces)}", _REMEDY)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise FrameError(path, f"{what}, but a face names a vertex that it does not have", _REMEDY)
    attributes, uv, colors = {}, -1, -1
    for attribute in mesh.attributes:
        number = int(attribute["unique_id"])
        attributes[number] = np.asarray(attribute["data"]).reshape(len(vertices), -1)
        # 2 is a colour, 3 a texture coordinate, 4 anything else
        if attribute["attribute_type"] == 3 and uv < 0 and attributes[number].shape[1] == 2:
            uv = number
        if attribute["attribute_type"] == 2 and colors < 0 and attributes[number].shape[1] >= 3:
            colors = number
    return DracoMesh(vertices, faces.astype(np.int32), attributes, uv, colors)
