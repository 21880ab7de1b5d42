"""The pictures of one transition as the report shows them, and as files."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Picture:
    """An encoded JPEG picture and its size in pixels."""

    data: bytes
    width: int
    height: int


@dataclass(frozen=True)
class Column:
    """One column of the contact sheet: ``kind`` is "source", "step" or "target"; ``label`` a frame's id or a step."""

    kind: str
    label: str


@dataclass(frozen=True)
class Seam:
    """A seam before and after.

    Attributes
    ----------
    picture : four pictures side by side: the frame before the seam, the frame after it, their difference, and the
        difference of the two captured frames that follow each other there in the capture
    labels : of the four
    change : mean absolute difference over the figure across the seam, 8-bit levels
    own_change : the same between the two captured frames
    """

    picture: Picture
    labels: tuple[str, str, str, str]
    change: float
    own_change: float


@dataclass(frozen=True)
class TransitionPictures:
    """What the report shows of one transition; small, picklable and made of encoded pictures.

    Attributes
    ----------
    source, target : ids of frames s and t
    columns : of the contact sheet, left to right
    sheet : two rows of ``len(columns)`` equal cells: the whole figure, and its upper part larger
    start, end : the seam from frame s-k to the first step, and from the last step to frame t+k
    film : all ``film_frames`` frames in playing order in one row of equal cells
    film_frames : how many
    film_steps : positions in the film of the first and last synthesized frame
    fps : frames a second of the capture
    """

    source: str
    target: str
    columns: tuple[Column, ...]
    sheet: Picture
    start: Seam
    end: Seam
    film: Picture
    film_frames: int
    film_steps: tuple[int, int]
    fps: float

    def files(self) -> dict[str, bytes]:
        """File names and contents: four JPEG pictures, and ``pictures.json`` with everything else."""
        pictures = {"sheet": self.sheet, "start": self.start.picture, "end": self.end.picture, "film": self.film}
        text = {
            "source": self.source,
            "target": self.target,
            "columns": [asdict(column) for column in self.columns],
            "seams": {
                name: {"labels": seam.labels, "change": seam.change, "own_change": seam.own_change}
                for name, seam in (("start", self.start), ("end", self.end))
            },
            "film_frames": self.film_frames,
            "film_steps": self.film_steps,
            "fps": self.fps,
            "sizes": {name: [picture.width, picture.height] for name, picture in pictures.items()},
        }
        files = {f"{name}.jpg": picture.data for name, picture in pictures.items()}
        return {**files, "pictures.json": (json.dumps(text, indent=1) + "\n").encode()}


def read_pictures(folder: Path) -> TransitionPictures:
    """Read what ``files`` was written to a folder as."""
    text: dict[str, Any] = json.loads((folder / "pictures.json").read_text())

    def picture(name: str) -> Picture:
        return Picture((folder / f"{name}.jpg").read_bytes(), *text["sizes"][name])

    def seam(name: str) -> Seam:
        entry = text["seams"][name]
        return Seam(picture(name), tuple(entry["labels"]), entry["change"], entry["own_change"])

    return TransitionPictures(
        text["source"],
        text["target"],
        tuple(Column(**column) for column in text["columns"]),
        picture("sheet"),
        seam("start"),
        seam("end"),
        picture("film"),
        text["film_frames"],
        tuple(text["film_steps"]),
        text["fps"],
    )
