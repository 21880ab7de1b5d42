"""A Matching on disk: ``dissimilarity.npz`` (scores, yaw and k, (n, n)) and ``matching.json`` (the rest)."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.match import Matching


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
    """Read back what ``write_matching`` wrote."""
    content = json.loads((folder / "matching.json").read_text())
    with np.load(folder / "dissimilarity.npz", allow_pickle=False) as arrays:
        scores, yaw, k = (arrays[name] for name in ("scores", "yaw", "k"))
    dissimilarity = Dissimilarity(scores, yaw, k, content["size"], content["unit"], content["rank_error"])
    keys = ("candidates", "nearest", "missing")
    candidates, nearest, missing = (tuple(Candidate(**entry) for entry in content[key]) for key in keys)
    return Matching(dissimilarity, candidates, nearest, missing, content["threshold"])
