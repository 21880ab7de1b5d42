"""A Matching on disk: ``dissimilarity.npz`` (scores, yaw and k, (n, n)) and ``matching.json`` (the rest)."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.geometry.array_file import Expected, as_written, read_arrays, read_json
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.match import Matching

_ARRAYS: dict[str, Expected] = {
    "scores": ("float32", ("n", "n"), None),
    "yaw": ("float32", ("n", "n"), None),
    "k": ("int16", ("n", "n"), None),
}


def write_matching(matching: Matching, folder: Path) -> None:
    """Write into ``folder``, made where it is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    dissimilarity = matching.dissimilarity
    d = dissimilarity
    np.savez(folder / "dissimilarity.npz", scores=d.scores, yaw=d.yaw, k=d.k)
    content = {
        "size": dissimilarity.size,
        "unit": dissimilarity.unit,
        "rank_error": dissimilarity.rank_error,
        "threshold": matching.threshold,
        "candidates": [asdict(candidate) for candidate in matching.candidates],
        "nearest": [asdict(candidate) for candidate in matching.nearest],
        "missing": [asdict(candidate) for candidate in matching.missing],
    }
    (folder / "matching.json").write_text(json.dumps(content, indent=1) + "\n")


def read_matching(folder: Path) -> Matching:
    """Read back what ``write_matching`` wrote. Raises UserError where a file is missing or something else."""
    arrays = read_arrays(folder / "dissimilarity.npz", _ARRAYS)
    path = folder / "matching.json"
    content: Any = read_json(path)
    with as_written(path):
        size, unit, threshold = float(content["size"]), str(content["unit"]), float(content["threshold"])
        rank_error = None if content["rank_error"] is None else float(content["rank_error"])
        candidates, nearest, missing = (
            tuple(_candidate(entry, len(arrays["scores"])) for entry in content[key])
            for key in ("candidates", "nearest", "missing")
        )
    dissimilarity = Dissimilarity(arrays["scores"], arrays["yaw"], arrays["k"], size, unit, rank_error)
    return Matching(dissimilarity, candidates, nearest, missing, threshold)


def read_candidates(path: Path, frames: int) -> tuple[Candidate, ...]:
    """Candidates that were written as a JSON list of their attributes; UserError where they are something else."""
    content: Any = read_json(path)
    with as_written(path):
        return tuple(_candidate(entry, frames) for entry in content)


def _candidate(entry: Any, frames: int) -> Candidate:
    source, target, k = (entry[key] for key in ("source", "target", "k"))
    if (
        not all(type(number) is int and 0 <= number < frames for number in (source, target))
        or type(k) is not int
        or k < 0
    ):
        raise ValueError(f"there are no frames {source} and {target}")
    warp = None
    if entry["warp"] is not None:
        own, other = entry["warp"]
        warp = tuple(own), tuple(other)
        if not _is_warp(warp, source, target, k, frames):
            raise ValueError(f"the warp of frames {source} and {target} is none")
    return Candidate(source, target, float(entry["score"]), float(entry["yaw"]), k, warp)


def _is_warp(warp: tuple[Any, ...], source: int, target: int, k: int, frames: int) -> bool:
    if any(len(way) != 2 * k + 1 for way in warp):
        return False
    if any(type(frame) is not int or not 0 <= frame < frames for way in warp for frame in way):
        return False
    steps = {b - a for way in warp for a, b in zip(way, way[1:], strict=False)}
    return steps <= {0, 1} and (warp[0][k], warp[1][k]) == (source, target)
