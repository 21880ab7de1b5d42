"""A sequence of OBJ + MTL + image."""

from collections.abc import Iterator

from unstructured_mg.capture.obj_writer import write_obj
from unstructured_mg.playback.export_format import ExportFrame, Format, Target


def write_frame(frame: ExportFrame, target: Target) -> str:
    """Write ``frame_00001.obj``, ``.mtl`` and its image, all of one stem.

    A frame of several materials has images ``frame_00001_1``, ``frame_00001_2``, ... Images are the stored bytes.
    """
    stem = target.stem(frame.number)
    images = []
    for index, texture in enumerate(frame.textures, start=1):
        ending = texture.suffix if len(frame.textures) == 1 else f"_{index}{texture.suffix}"
        images.append(stem + ending)
        (target.folder / images[-1]).write_bytes(texture.data)
    write_obj(
        target.folder / f"{stem}.obj",
        frame.vertices(),
        frame.faces,
        frame.uv,
        frame.face_uv,
        tuple(images),
        frame.face_material,
        frame.colors,
    )
    return f"{stem}.obj"


def name_files(written: Iterator[str], target: Target) -> list[str]:
    return list(written)


OBJ = Format("obj", r"frame_\d{5,}(_\d+)?\.\w+", write_frame, name_files)
