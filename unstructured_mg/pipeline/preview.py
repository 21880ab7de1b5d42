"""``umg build --preview``: the same road, fast: decimated frames, a coarser grid, textures that only fade."""

from dataclasses import dataclass, replace
from typing import Any

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.decimated import decimated_mesh
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.pipeline.options import BuildOptions

# Triangles of a frame: limbs keep their shape, folds do not.
FACES = 3000
# A quarter of a cage's vertices and texels: enough to judge a transition by.
CAGE_VERTICES = 500
TEXTURE_SIZE = 256
RESOLUTION = 32


@dataclass(frozen=True)
class PreviewCapture(Capture):
    """A capture whose frames have at most ``faces`` triangles when they are read; the files stay as they are."""

    faces: int = FACES

    def read(self, index: int) -> TexturedMesh:
        return decimated_mesh(super().read(index), self.faces)


def preview_capture(capture: Capture) -> PreviewCapture:
    return PreviewCapture(
        capture.folder,
        capture.frames,
        capture.fps,
        capture.unit,
        capture.up,
        capture.floor,
        capture.faults,
        capture.warnings,
        FACES,
    )


def preview_options(options: BuildOptions) -> BuildOptions:
    """The same options where a preview leaves them, for what a user can judge in it: which pairs, and how they move."""
    synthesis = replace(
        options.synthesis,
        texture="none" if options.synthesis.texture == "none" else "crossfade",
        texturing=replace(options.synthesis.texturing, texture_size=TEXTURE_SIZE),
    )
    return replace(
        options,
        preview=True,
        matching=replace(options.matching, resolution=RESOLUTION),
        tracking=replace(options.tracking, cage_vertices=CAGE_VERTICES),
        synthesis=synthesis,
    )


def preview_inputs(options: BuildOptions) -> dict[str, Any]:
    """What an artefact's inputs say of decimated frames: nothing where frames are read as they are."""
    return {"preview_faces": FACES} if options.preview else {}
