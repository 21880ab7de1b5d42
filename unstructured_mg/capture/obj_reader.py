"""Reading one OBJ frame: the .obj, its .mtl and which images they name."""

from pathlib import Path

import numpy as np

from unstructured_mg import _native
from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.image import SUFFIXES
from unstructured_mg.capture.mtl import read_mtl
from unstructured_mg.capture.paths import capture_roots, decode_text, find_beside, find_named, read_regular_file
from unstructured_mg.capture.raw_mesh import RawMesh
from unstructured_mg.capture.texture import Texture

# The faults of native/obj.c, in its order.
_FAULTS = (
    "",
    "line {line} does not hold the numbers that belong there",
    "line {line} holds a face corner that is no index",
    "line {line} holds a face of fewer than three corners",
    "line {line} names vertex {detail}, which the file does not have",
    "line {line} names texture coordinate {detail}, which the file does not have",
    "it holds more than was counted",
)


def read_obj(path: Path, folder: Path) -> RawMesh:
    """Read an OBJ file, and of its MTL which images it names. ``folder`` is the capture's: nothing outside is touched.

    Understood: ``v`` with and without colour (0..1 or 0..255), ``vt``, ``f`` with negative indices, without uv, of any
    number of corners (made a fan around the first), ``usemtl``, ``mtllib``; continued lines; LF, CRLF and CR. Normals,
    lines, groups and curves are passed over. Where no MTL names an image, one of the same stem beside the OBJ is taken.

    Raises
    ------
    FrameError : the file is unreadable or malformed, has no vertices or faces, an index is out of range, an image or
        MTL path leads outside ``folder``, or an image that the MTL names is not there
    """
    text = read_regular_file(path)
    if b"\r" in text and b"\n" not in text:
        text = text.replace(b"\r", b"\n")
    if b"\\" in text:
        text = text.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    if text.startswith(b"\xef\xbb\xbf"):
        text = text[3:]
    vertex_count, uv_count, face_count, statement_count = _native.obj_count(text)
    if vertex_count == 0 or face_count == 0:
        lacking = "vertices" if vertex_count == 0 else "faces"
        raise FrameError(path, f"it holds no {lacking}", "export the frame again as an OBJ triangle mesh")
    if vertex_count * len(b"v 0 0 0") > len(text):  # before memory is taken for what cannot be there
        raise FrameError(path, "its vertex lines do not hold three numbers each", "export the frame again")
    vertices = np.empty((vertex_count, 3))
    raw_colors = np.full((vertex_count, 3), np.nan)
    uv = np.empty((uv_count, 2))
    faces = np.empty((face_count, 3), np.int32)
    face_uv = np.empty((face_count, 3), np.int32)
    face_statement = np.empty(face_count, np.int32)
    ranges = np.empty((statement_count, 2), np.int64)
    fault, line, detail = _native.obj_read(text, vertices, raw_colors, uv, faces, face_uv, face_statement, ranges)
    if fault:
        raise FrameError(path, _FAULTS[fault].format(line=line, detail=detail), "export the frame again")
    statements = [decode_text(text[start:stop]).strip() for start, stop in ranges]
    libraries = [_argument(statement) for statement in statements if statement.startswith("mtllib")]
    roots = capture_roots(path, folder)
    named, library_files = _read_libraries(libraries, path, roots)
    materials = ["" if statement.startswith("mtllib") else _argument(statement) for statement in statements]
    images, face_image = _images(path, roots, materials, face_statement, named)
    return RawMesh(
        vertices=vertices,
        faces=faces,
        uv=uv,
        face_uv=face_uv,
        colors=_colors(raw_colors),
        images=tuple(Texture(image) for image in images),
        face_image=face_image,
        files=(path, *library_files, *images),
    )


def _argument(statement: str) -> str:
    return statement[len("usemtl") :].strip()


def _read_libraries(
    libraries: list[str], path: Path, roots: tuple[Path, ...]
) -> tuple[dict[str, tuple[str, Path]], list[Path]]:
    """Material name to its image's name and the MTL file that says so; and the MTL files read.

    An MTL that is not there is no fault of its own: the geometry needs none, and an image of the OBJ's stem may be
    there.
    """
    named: dict[str, tuple[str, Path]] = {}
    files: list[Path] = []
    for argument in libraries:
        # one name with spaces, or several names: the whole is tried first
        whole = find_named(argument, path, roots) if argument else None
        found = [whole] if whole else [find_named(word, path, roots) for word in argument.split()]
        for file in found:
            if file is None or file in files:
                continue
            files.append(file)
            for material, image in read_mtl(decode_text(read_regular_file(file))).items():
                named.setdefault(material, (image, file))
    return named, files


def _images(
    path: Path,
    roots: tuple[Path, ...],
    materials: list[str],
    face_statement: np.ndarray,
    named: dict[str, tuple[str, Path]],
) -> tuple[tuple[Path, ...], np.ndarray]:
    used = np.unique(face_statement)
    names = {int(statement): materials[statement] if statement >= 0 else "" for statement in used}
    if not any(name in named for name in names.values()):
        # nothing that the faces use has an image: the MTL's only one, else the one beside the OBJ
        if len(named) == 1:
            names = dict.fromkeys(names, next(iter(named)))
        else:
            beside = find_beside(path, SUFFIXES, roots)
            return (() if beside is None else (beside,)), np.full(len(face_statement), 0 if beside else -1, np.int32)
    images: list[Path] = []
    image_of_statement = np.full(len(materials) + 1, -1, np.int32)  # the last serves faces before any usemtl
    for statement in used:
        if names[int(statement)] not in named:
            continue
        name, library = named[names[int(statement)]]
        image = find_named(name, library, roots)
        if image is None:
            raise FrameError(path, f'its texture "{name}" is not there', "put the image beside the mesh")
        if image not in images:
            images.append(image)
        image_of_statement[statement] = images.index(image)
    return tuple(images), image_of_statement[face_statement]


def _colors(raw: np.ndarray) -> np.ndarray | None:
    """Colours of ``v`` lines to bytes. They are 0..1, or 0..255 where any exceeds 1; white where a vertex has none."""
    given = np.isfinite(raw)
    if not given.any():
        return None
    scale = 1.0 if np.max(raw, where=given, initial=0.0) > 1.0 else 255.0
    return np.rint(np.clip(np.where(given, raw * scale, 255.0), 0, 255)).astype(np.uint8)
