"""Which files of a folder are frames: clips, frame numbers, natural order."""

import os
import re
from pathlib import Path

from unstructured_mg.capture.capture import FrameFile
from unstructured_mg.capture.frame_reader import READERS
from unstructured_mg.errors import FrameFault, UserError


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Sorts ``take2`` before ``take10``."""
    words = re.split(r"([0-9]+)", name)
    return tuple((1, int(word), word) if i % 2 else (0, 0, word) for i, word in enumerate(words))


def list_frames(folder: Path) -> tuple[list[FrameFile], list[FrameFault], list[str]]:
    """Frame files of a capture in playing order, faults of numbering, and warnings.

    The folder itself is a clip where it holds mesh files (named ``.``), and so is each folder in it that does. Hidden
    files and folders are passed over. A frame's number is the one run of digits in the file names that differs most
    often from file to file, the last of them where several do; files without digits are not frames.
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
    for clip in [".", *(name for name in names if (folder / name).is_dir())]:
        path = folder if clip == "." else folder / clip
        try:
            meshes = sorted(
                (
                    name
                    for name in os.listdir(path)
                    if Path(name).suffix.lower() in READERS and not name.startswith(".")
                ),
                key=natural_key,
            )
        except OSError as error:
            warnings.append(f"folder {clip} is left out: it cannot be listed ({error.strerror})")
            continue
        _list_clip(clip, path, meshes, frames, faults, warnings)
    return frames, faults, warnings


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


def frame_numbers(names: list[str]) -> dict[str, int]:
    """The frame number in each file name that has one: of a naming pattern's runs of digits the one that varies
    most.
    """
    patterns: dict[tuple[str, ...], list[tuple[str, list[str]]]] = {}
    for name in names:
        words = re.split(r"([0-9]+)", Path(name).stem)
        if len(words) > 1:
            patterns.setdefault(tuple(word.lower() for word in words[::2]), []).append((name, words[1::2]))
    numbers = {}
    for files in patterns.values():
        varieties = [len({runs[i] for _, runs in files}) for i in range(len(files[0][1]))]
        most = max(varieties)
        place = max(i for i, variety in enumerate(varieties) if variety == most)
        numbers.update({name: int(runs[place]) for name, runs in files})
    return numbers
