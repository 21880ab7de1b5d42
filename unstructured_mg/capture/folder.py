"""Which files of a folder are frames: clips, frame numbers, natural order."""

import os
from dataclasses import dataclass
from pathlib import Path

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.frame_file import FrameFile
from unstructured_mg.capture.frame_reader import READERS
from unstructured_mg.capture.numbering import frame_numbers, natural_key
from unstructured_mg.capture.sequences import find_sequence
from unstructured_mg.errors import FrameFault, UserError


@dataclass(frozen=True)
class Listing:
    """Frames in playing order, faults that were seen by listing alone, warnings, and, by clip, the rate that a file of
    many frames states.
    """

    frames: list[FrameFile]
    faults: list[FrameFault]
    warnings: list[str]
    rates: dict[str, float]


def list_frames(folder: Path) -> Listing:
    """The frames of a capture.

    The folder itself is a clip where it holds mesh files (named ``.``), and so is each folder in it that does. Hidden
    files and folders are passed over. A frame's number is the one run of digits in the file names that differs most
    often from file to file, the last of them where several do; files without digits are not frames. A clip may be one
    file that holds or lists many frames instead (see sequences.py); folders in it are then parts of it.
    """
    if not folder.is_dir():
        raise UserError(f"{folder}: there is no such folder; give the folder that holds the frames.")
    try:
        names = sorted((entry.name for entry in os.scandir(folder) if not entry.name.startswith(".")), key=natural_key)
    except OSError as error:
        raise UserError(f"{folder}: it cannot be listed ({error.strerror}); check the folder's permissions.") from None
    frames: list[FrameFile] = []
    faults: list[FrameFault] = []
    warnings: list[str] = []
    rates: dict[str, float] = {}
    for clip in [".", *(name for name in names if (folder / name).is_dir())]:
        path = folder if clip == "." else folder / clip
        try:
            inside = sorted((name for name in os.listdir(path) if not name.startswith(".")), key=natural_key)
        except OSError as error:
            warnings.append(f"folder {clip} is left out: it cannot be listed ({error.strerror})")
            continue
        try:
            sequence = find_sequence(path, inside, folder)
        except FrameError as error:
            faults.append(FrameFault(clip, 0, str(error.file), error.fault, error.remedy))
            continue
        if sequence is None:
            meshes = [name for name in inside if Path(name).suffix.lower() in READERS]
            _list_clip(clip, path, meshes, frames, faults, warnings)
            continue
        frames += [
            FrameFile(clip, number, sequence.path, part=part, format=sequence.format)
            for part, number in enumerate(sequence.numbers)
        ]
        if sequence.fault is not None:
            rest = sequence.fault
            faults.append(FrameFault(clip, sequence.numbers[-1] + 1, str(rest.file), rest.fault, rest.remedy))
        if sequence.fps is not None:
            rates[clip] = sequence.fps
        if clip == ".":
            break
    return Listing(frames, faults, warnings, rates)


def _list_clip(
    clip: str, path: Path, names: list[str], frames: list[FrameFile], faults: list[FrameFault], warnings: list[str]
) -> None:
    numbers = frame_numbers(names)
    unnumbered = [name for name in names if name not in numbers]
    if unnumbered:
        warnings.append(
            f"{len(unnumbered)} files without a frame number are left out, the first is {path / unnumbered[0]}"
        )
    taken: dict[int, str] = {}
    # of one frame in two formats the one in the clip's usual format counts
    usual = max(READERS, key=lambda suffix: sum(name.lower().endswith(suffix) for name in names))
    for name in sorted(numbers, key=lambda name: (numbers[name], not name.lower().endswith(usual), natural_key(name))):
        number = numbers[name]
        if number not in taken:
            taken[number] = name
            frames.append(FrameFile(clip, number, path / name))
        elif Path(taken[number]).stem != Path(name).stem:
            faults.append(
                FrameFault(
                    clip,
                    number,
                    str(path / name),
                    f"frame {number} is already there as {taken[number]}",
                    "keep one of the two, or give each sequence a folder of its own",
                )
            )
