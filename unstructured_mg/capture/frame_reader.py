"""One frame's files to a checked mesh in the file's own unit and axis."""

from pathlib import Path

import numpy as np

from unstructured_mg.capture.frame_error import FrameError, malformed
from unstructured_mg.capture.frame_file import FrameFile
from unstructured_mg.capture.gltf_reader import read_gltf
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.capture.obj_reader import read_obj
from unstructured_mg.capture.ply_reader import read_ply
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.sequences import read_part
from unstructured_mg.capture.tidy import Tidied, tidy
from unstructured_mg.geometry.laplacian import face_areas

#: Reader by suffix; also the order of choice where a frame has several files.
READERS = {".obj": read_obj, ".ply": read_ply, ".glb": read_gltf, ".gltf": read_gltf}

#: Coordinates beyond this, in the file's unit, are a broken export: beside them the body's own size would be lost.
LARGEST_COORDINATE = 1e9


def read_frame(frame: FrameFile, folder: Path) -> tuple[TexturedMesh, Tidied, RawMesh]:
    """Read, check and tidy a frame of the capture in ``folder``. Images are named, not opened.

    Raises
    ------
    FrameError : as the reader of that format; also for values that are not finite, and for faces without any area
    """
    path = frame.path
    with np.errstate(invalid="ignore", over="ignore"):  # values that are not finite are refused below
        if frame.part is None:
            with malformed(path):
                raw = READERS[path.suffix.lower()](path, folder)
        else:
            raw = read_part(path, folder, frame.format, frame.part)
    remedy = "export the frame again"
    for values, name in ((raw.vertices, "vertex"), (raw.uv, "texture coordinate")):
        with np.errstate(invalid="ignore"):
            usable = (np.abs(values) <= LARGEST_COORDINATE).all(axis=1)  # not so for NaN
        if not usable.all():
            first = int(np.argmin(usable))
            limit = (
                f"exceeds {LARGEST_COORDINATE:.0e}" if np.isfinite(values[first]).all() else "is not a finite number"
            )
            raise FrameError(path, f"{name} {first + 1} {limit}", remedy)
    mesh, tidied = tidy(raw)
    # block by block: the first nearly always settles it
    blocks = (mesh.faces[start : start + 1024] for start in range(0, len(mesh.faces), 1024))
    if not any((face_areas(mesh.vertices, block) > 0).any() for block in blocks):
        raise FrameError(path, "none of its faces has any area", remedy)
    if mesh.textures and len(mesh.uv) == 0:
        raise FrameError(path, "it has a texture but no texture coordinates", "export the frame with its uvs")
    return mesh, tidied, raw
