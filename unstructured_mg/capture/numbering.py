"""The numbers in names: natural order, and which of them is a frame's."""

import re
from pathlib import Path


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Sorts ``take2`` before ``take10``."""
    words = re.split(r"([0-9]+)", name)
    return tuple((1, int(word), word) if i % 2 else (0, 0, word) for i, word in enumerate(words))


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
