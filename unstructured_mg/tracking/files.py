"""A tracked pair on disk: ``tracked.npz`` and ``tracked.json``."""

import json
from pathlib import Path

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.tracking.pair import TrackedPair

_ARRAYS = (
    "frames",
    "vertices",
    "faces",
    "uv",
    "face_uv",
    "cage_vertices",
    "tets",
    "tet_of_vertex",
    "weights",
    "residual",
)
_VALUES = ("source", "target", "k", "template", "yaw")


def write_pair(pair: TrackedPair, capture: Capture, folder: Path) -> None:
    """Write into an existing folder. Measures are arrays ``measure_<name>``; the JSON holds the rest and frame ids."""
    arrays = {name: getattr(pair, name) for name in _ARRAYS}
    if pair.face_material is not None:
        arrays["face_material"] = pair.face_material
    arrays |= {f"measure_{name}": values for name, values in sorted(pair.measures.items())}
    np.savez(folder / "tracked.npz", **arrays)
    values = {name: getattr(pair, name) for name in _VALUES}
    values["frame_ids"] = [capture.frame_id(int(frame)) for frame in pair.frames]
    (folder / "tracked.json").write_text(json.dumps(values, indent=1))


def read_pair(folder: Path) -> TrackedPair:
    """What ``write_pair`` wrote."""
    values = json.loads((folder / "tracked.json").read_text())
    with np.load(folder / "tracked.npz", allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    return TrackedPair(
        **{name: values[name] for name in _VALUES},
        **{name: arrays[name] for name in _ARRAYS},
        face_material=arrays.get("face_material"),
        measures={name[8:]: array for name, array in arrays.items() if name.startswith("measure_")},
    )
