"""The signal toy with textures in files, as exporters and the viewer want them."""

from dataclasses import replace
from pathlib import Path

from signal_toy import color, encoded
from toy_capture import ToyCapture

from unstructured_mg.capture.mesh import Texture, TexturedMesh


def on_disk(capture: ToyCapture, folder: Path) -> ToyCapture:
    for index in range(len(capture)):
        (folder / f"{index}.png").write_bytes(encoded(color(index)))

    def mesh(index: int) -> TexturedMesh:
        assert capture.mesh_of is not None
        return replace(capture.mesh_of(index), textures=(Texture(folder / f"{index}.png"),))

    return replace(capture, mesh_of=mesh)
