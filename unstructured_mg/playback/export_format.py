"""What a format's exporter gets, and what it must give."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.capture.placement import UP_AXES
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.stream import EncodedImage
from unstructured_mg.playback.world import ExportSpace


@dataclass(frozen=True)
class ExportFrame:
    """One frame to be written, in the export's axis and unit.

    Attributes
    ----------
    number : of the frame in the export, from 0
    key : equal for frames of the same content: only ``world`` may differ
    own_vertices : (n, 3) float64, where the frame was captured (of a transition: its source was)
    world : (4, 4) float64, row-major, on column vectors: from there to its place in the walk
    faces, uv, face_uv, face_material, colors : as in TexturedMesh
    textures : one a material; empty where there is none
    view : what the format's ``plan`` made for this frame, else None
    """

    number: int
    key: tuple[int, ...]
    own_vertices: np.ndarray
    world: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    face_uv: np.ndarray
    face_material: np.ndarray | None
    colors: np.ndarray | None
    textures: tuple[EncodedImage, ...]
    view: Any = None

    def vertices(self) -> np.ndarray:
        """(n, 3) float64 in their place in the walk."""
        return self.own_vertices @ self.world[:3, :3].T + self.world[:3, 3]


@dataclass(frozen=True)
class Target:
    """Where an export goes.

    Attributes
    ----------
    folder : exists and is empty; becomes the output when all is written
    count : frames that will come
    fps : frames a second
    first_number : of the first frame's file or time code
    space : axis and unit
    options : what was asked for
    """

    folder: Path
    count: int
    fps: float
    first_number: int
    space: ExportSpace
    options: ExportOptions = ExportOptions()

    def stem(self, number: int) -> str:
        """Of the files of frame ``number`` (from 0): ``frame_00001`` for the first."""
        width = max(5, len(str(self.first_number + self.count - 1)))
        return f"frame_{self.first_number + number:0{width}d}"


@dataclass(frozen=True)
class Format:
    """A format: one file, one instance of this, one line in ``playback.export.FORMATS``.

    Attributes
    ----------
    name : of the format
    files : regular expression of all file names that it writes
    prepare : makes of a frame what ``collect`` needs, or writes its files; runs in workers, for several frames at once
        and in any order
    collect : gets what ``prepare`` made, in order, and writes what must be written in order; gives each frame's file
    unused : names of the ExportOptions that mean nothing here, and why
    pictures : whether it shows frames from a camera: others have no use for ``camera`` and ``picture_height``
    space : up axis and metres a unit, where the format knows no others
    axes : the up axes that it knows; a capture with another one is exported with the first of them
    measure, plan : where not None, all that is shown is looked at before anything is prepared: ``measure`` makes of
        each distinct frame (in workers) what ``plan`` needs, and ``plan``, which gets that of every frame that will
        be shown, with its world, gives each one's ``view``
    require : raises UserError where a package or program that it needs is not there
    """

    name: str
    files: str
    prepare: Callable[[ExportFrame, Target], Any]
    collect: Callable[[Iterator[Any], Target], list[str]]
    unused: Mapping[str, str] = field(default_factory=dict)
    pictures: bool = False
    space: tuple[str, float] | None = None
    axes: tuple[str, ...] = tuple(UP_AXES)
    measure: Callable[[ExportFrame], Any] | None = None
    plan: Callable[[Sequence[Any], Sequence[np.ndarray], Target], Sequence[Any]] | None = None
    require: Callable[[], None] | None = None
