"""Frames to export without a capture, for tests of one format."""

import io
from pathlib import Path

import numpy as np
from PIL import Image
from toy_capture import toy_capture

from unstructured_mg.playback.export_format import ExportFrame, Target
from unstructured_mg.playback.stream import EncodedImage
from unstructured_mg.playback.world import export_space

# A square of two triangles: the diagonal's ends have two uvs each.
VERTICES = np.array([[0.1, 0, 0], [1, 0, 0.25], [1, 0.5, 1], [0, 0, 1]])
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
UV = np.array([[0.0, 0], [0.5, 0], [0.5, 0.75], [0.5, 0.125], [1, 1], [0.5, 1]])
FACE_UV = np.array([[0, 1, 2], [3, 4, 5]], np.int32)


def picture(color, suffix=".png", size=(4, 6)) -> EncodedImage:
    """One colour of (height, width) ``size``, or (height, width, 3) pixels."""
    data = io.BytesIO()
    pixels = color if np.ndim(color) == 3 else np.full((*size, 3), color, np.uint8)
    kind = {".jpg": "JPEG", ".png": "PNG", ".bmp": "BMP"}[suffix]
    Image.fromarray(pixels).save(data, kind)
    return EncodedImage(data.getvalue(), suffix)


def decoded(texture: EncodedImage) -> np.ndarray:
    with Image.open(io.BytesIO(texture.data)) as image:
        return np.asarray(image.convert("RGB"))


def export_frame(number=0, textures=None, **changed) -> ExportFrame:
    """One frame; what is not given is a textured square in its own place."""
    frame = {
        "key": (number,),
        "own_vertices": VERTICES + [0, 0, 0.5 * number],
        "world": np.eye(4),
        "faces": FACES,
        "uv": UV,
        "face_uv": FACE_UV,
        "face_material": None,
        "colors": None,
        "textures": (picture((200, 10 * number, 30)),) if textures is None else textures,
    }
    return ExportFrame(number=number, **{**frame, **changed})


def target(folder: Path, count: int, fps=30.0, first_number=1, up="y", unit=1.0) -> Target:
    return Target(folder, count, fps, first_number, export_space(toy_capture(3, up=up, unit=unit)))


def write(form, folder: Path, frames, **options) -> list[str]:
    """What the format says of its files, after writing all frames."""
    goal = target(folder, len(frames), **options)
    return form.collect((form.prepare(frame, goal) for frame in frames), goal)
