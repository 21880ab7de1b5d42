"""One frame's files to a checked mesh in the file's own unit and axis."""

from pathlib import Path

import numpy as np

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.capture.obj_reader import read_obj
from unstructured_mg.capture.ply_reader import read_ply
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.tidy import Tidied, tidy
from unstructured_mg.geometry.laplacian import face_areas

#: Reader by suffix; also the order of choice where a frame has several files.
READERS = {".obj": read_obj, ".ply": read_ply}

#: Coordinates beyond this, in the file's unit, are a broken export: squares of them would lose the body's own size.
LARGEST_COORDINATE = 1e9


def read_frame(path: Path, folder: Path) -> tuple[TexturedMesh, Tidied, RawMesh]:
    """Read, check and tidy a frame of the capture in ``folder``. Images are named, not opened.

    Raises
    ------
    FrameError : as the reader of that format; also for values that are not finite, and for faces without any area
    """
    raw = READERS[path.suffix.lower()](path, folder)
    remedy = "export the frame again"
    finite = np.isfinite(raw.vertices).all(axis=1)
    if not finite.all():
        raise FrameError(path, f"vertex {int(np.argmin(finite)) + 1} is not a number (or not finite)", remedy)
    if np.abs(raw.vertices).max() > LARGEST_COORDINATE:
        raise FrameError(path, f"a coordinate exceeds {LARGEST_COORDINATE:.0e}", remedy)
    finite = np.isfinite(raw.uv).all(axis=1)
    if not finite.all():
        raise FrameError(
            path, f"texture coordinate {int(np.argmin(finite)) + 1} is not a number (or not finite)", remedy
        )
    mesh, tidied = tidy(raw)
    if not face_areas(mesh.vertices, mesh.faces).sum() > 0:
        raise FrameError(path, "none of its faces has any area", remedy)
    if mesh.textures and len(mesh.uv) == 0:
        raise FrameError(path, "it has a texture but no texture coordinates", "export the frame with its uvs")
    return mesh, tidied, raw
