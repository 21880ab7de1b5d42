"""Small captures for tests: a capsule the size of a person in every frame, and all the ways a frame can be bad."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from PIL import Image

from unstructured_mg.capture.obj_writer import write_obj

BODY = trimesh.creation.capsule(height=1.3, radius=0.2, count=[12, 12])
BODY_VERTICES = np.array(BODY.vertices)[:, [0, 2, 1]] + [0, 0.85, 0]  # y up, from 0 to 1.7
BODY_FACES = np.array(BODY.faces, np.int32)[:, ::-1]
BODY_UV = BODY_VERTICES[:, :2] / 2.5 + 0.2  # front and back share the texture


def write_frame(
    folder: Path, number: int, pattern: str = "frame_{:04d}", vertices: np.ndarray = BODY_VERTICES, texture: bool = True
) -> None:
    """One OBJ frame, with MTL and PNG where it has a texture."""
    folder.mkdir(exist_ok=True, parents=True)
    stem = pattern.format(number)
    images = ()
    if texture:
        images = (f"{stem}.png",)
        Image.new("RGB", (8, 8), (number % 256, 100, 50)).save(folder / images[0])
    write_obj(folder / f"{stem}.obj", vertices, BODY_FACES, BODY_UV, BODY_FACES, images)


def write_frames(folder: Path, numbers: Iterable[int], **options: Any) -> Path:
    """Frames of these numbers; returns the folder."""
    for number in numbers:
        write_frame(folder, number, **options)
    return folder


def break_frames(folder: Path) -> dict[int, str]:
    """Write frames 0 to 29, many of them bad; returns what the fault of each must say. Frame 1 is not there at all."""
    write_frames(folder, range(30))
    obj = [folder / f"frame_{i:04d}.obj" for i in range(30)]
    text = obj[0].read_text()
    obj[1].unlink()
    obj[2].write_text("")
    obj[3].write_text("not a mesh")
    obj[4].write_text(text.replace("v ", "v nan ", 1))
    obj[5].write_text(text + "f 1/1 2/2 99999/1\n")
    obj[6].with_suffix(".png").unlink()
    obj[7].with_suffix(".png").write_bytes(obj[7].with_suffix(".png").read_bytes()[:40])
    obj[8].with_suffix(".mtl").write_text("newmtl material_0\nmap_Kd ../other.png\n")
    obj[9].write_text("".join(line for line in text.splitlines(True) if not line.startswith("f")))
    obj[10].unlink()
    os.mkfifo(obj[10])
    obj[11].write_text(text[: len(text) // 2])
    obj[12].with_suffix(".mtl").unlink()
    obj[12].with_suffix(".png").unlink()
    return {
        2: "the file is empty",
        3: "it holds no vertices",
        4: "vertex 1 is not a finite number",
        5: "names vertex 99999",
        6: 'its texture "frame_0006.png" is not there',
        7: "cannot be decoded",
        8: 'the path "../other.png" leads outside the capture folder',
        9: "it holds no faces",
        10: "it is not a regular file",
        11: "",
        12: "it has no texture, though other frames have one",
    }
