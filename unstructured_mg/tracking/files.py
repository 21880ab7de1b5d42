"""A tracked pair on disk: ``tracked.npz`` and ``tracked.json``."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.geometry.array_file import Expected, as_written, read_arrays, read_json
from unstructured_mg.tracking.pair import TrackedPair

_ARRAYS: dict[str, Expected] = {
    "frames": ("int32", ("f",), None),
    "vertices": ("float64", ("f", "n", 3), None),
    "faces": ("int32", ("m", 3), "n"),
    "uv": ("float64", ("u", 2), None),
    "face_uv": ("int32", ("mu", 3), "u"),
    "cage_vertices": ("float64", ("f", "c", 3), None),
    "tets": ("int32", ("q", 4), "c"),
    "tet_of_vertex": ("int32", ("n",), "q"),
    "weights": ("float64", ("n", 4), None),
    "residual": ("float64", ("f", "n", 3), None),
}
_OPTIONAL: dict[str, Expected] = {
    "face_material": ("int32", ("m",), None),
    "measure_*": ("float64", ("f",), None),
    "warp": ("int32", (2, "steps"), "f"),
}
_VALUES = {"source": int, "target": int, "k": int, "template": int, "yaw": float}


def write_pair(pair: TrackedPair, capture: Capture, folder: Path) -> None:
    """Write into an existing folder. Measures are arrays ``measure_<name>``; the JSON holds the rest and frame ids."""
    arrays = {name: getattr(pair, name) for name in _ARRAYS}
    if pair.face_material is not None:
        arrays["face_material"] = pair.face_material
    if pair.warp is not None:
        arrays["warp"] = pair.warp
    arrays |= {f"measure_{name}": values for name, values in sorted(pair.measures.items())}
    np.savez(folder / "tracked.npz", **arrays)
    values = {name: getattr(pair, name) for name in _VALUES}
    values["frame_ids"] = [capture.frame_id(int(frame)) for frame in pair.frames]
    (folder / "tracked.json").write_text(json.dumps(values, indent=1))


def read_pair(folder: Path) -> TrackedPair:
    """What ``write_pair`` wrote. Raises UserError where a file is missing or something else."""
    path = folder / "tracked.json"
    content: Any = read_json(path)
    with as_written(path):
        values: dict[str, Any] = {name: kind(content[name]) for name, kind in _VALUES.items()}
    arrays: dict[str, Any] = read_arrays(folder / "tracked.npz", _ARRAYS, _OPTIONAL)
    return TrackedPair(
        **values,
        **{name: arrays[name] for name in _ARRAYS},
        face_material=arrays.get("face_material"),
        warp=arrays.get("warp"),
        measures={name[8:]: array for name, array in arrays.items() if name.startswith("measure_")},
    )
