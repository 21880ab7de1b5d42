"""A transition on disk: arrays, one image a step, and the quality card."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.geometry.array_file import Expected, as_written, read_arrays, read_json
from unstructured_mg.geometry.centre import floor_centre
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.texture_flow import TextureFlow
from unstructured_mg.synthesis.transition import Transition

# The images of steps -k and k.
END_NAMES = ("start", "end")


_GEOMETRY: dict[str, Expected] = {
    "vertices": ("float64", ("steps", "n", 3), None),
    "faces": ("int32", ("m", 3), "n"),
    "uv": ("float64", ("u", 2), None),
    "face_uv": ("int32", ("mu", 3), "u"),
    "alignment": ("float64", (3,), None),
    "window": ("int64", (3,), None),
}
_OPTIONAL: dict[str, Expected] = {"colors": ("uint8", ("steps", "n", 3), None), "ends": ("int64", (2,), None)}
_FLOW: dict[str, Expected] = {
    "reference": ("float32", ("n", 3), None),
    "displacement": ("float32", ("n", 3), None),
    "uv_flow": ("float32", ("u", 2), None),
}
_COLORS: dict[str, Expected] = {"colors": ("uint8", (2, "n", 3), None)}


def step_name(step: int) -> str:
    """``step_-09``, ``step_00``, ``step_09``: the stem of a step's image."""
    return f"step_{step:03d}" if step < 0 else f"step_{step:02d}"


def write_transition(transition: Transition, folder: Path) -> None:
    """Write ``geometry.npz``, ``card.json`` and, where there are textures, ``step_-09.jpg`` ... into ``folder``.

    Where there is a flow, ``flow.npz`` holds it, with ``start.jpg`` and ``end.jpg`` beside it where there are images.

    ``geometry.npz`` (never pickled) holds ``vertices``, ``faces``, ``uv``, ``face_uv``, ``alignment`` (yaw in
    radians, x and y in metres), ``window`` (source, target, k) and, where there are any, ``colors`` and ``ends``.
    ``card.json`` is the quality card.
    """
    folder.mkdir(parents=True, exist_ok=True)
    arrays = {
        "vertices": transition.vertices,
        "faces": transition.faces,
        "uv": transition.uv,
        "face_uv": transition.face_uv,
        "alignment": np.array([transition.alignment.yaw, transition.alignment.x, transition.alignment.y]),
        "window": np.array([transition.source, transition.target, transition.k], dtype=np.int64),
    }
    if transition.colors is not None:
        arrays["colors"] = transition.colors
    if transition.ends is not None:
        arrays["ends"] = np.array(transition.ends, dtype=np.int64)
    np.savez(folder / "geometry.npz", **arrays)  # type: ignore[arg-type]
    for step, image in zip(range(-transition.k + 1, transition.k), transition.textures, strict=False):
        (folder / (step_name(step) + transition.texture_suffix)).write_bytes(image)
    if transition.flow is not None:
        _write_flow(transition.flow, folder)
    (folder / "card.json").write_text(json.dumps(transition.card, indent=2, allow_nan=False) + "\n")


def _write_flow(flow: TextureFlow, folder: Path) -> None:
    arrays = {"reference": flow.reference, "displacement": flow.displacement, "uv_flow": flow.uv_flow}
    if flow.colors is not None:
        arrays["colors"] = flow.colors
    np.savez(folder / "flow.npz", **arrays)  # type: ignore[arg-type]
    for name, image in zip(END_NAMES, flow.textures, strict=False):
        (folder / (name + flow.texture_suffix)).write_bytes(image)


def read_flow(folder: Path) -> TextureFlow | None:
    """Both end textures and the flow of what ``write_transition`` wrote; None where a transition has no colour."""
    if not (folder / "flow.npz").exists():
        return None
    suffix = _suffix(folder, END_NAMES[0])
    arrays = read_arrays(folder / "flow.npz", _FLOW, _COLORS)
    with as_written(folder):
        return TextureFlow(
            arrays["reference"],
            arrays["displacement"],
            arrays["uv_flow"],
            tuple((folder / (name + suffix)).read_bytes() for name in END_NAMES) if suffix else (),
            suffix,
            arrays.get("colors"),
        )


def _suffix(folder: Path, name: str) -> str:
    """The ending of the image ``name`` in ``folder``, empty where there is none."""
    return next((suffix for suffix in (".jpg", ".png") if (folder / (name + suffix)).exists()), "")


def read_transition(folder: Path) -> Transition:
    """Read what ``write_transition`` wrote. Raises UserError where a file is missing or something else."""
    arrays, path = _read_geometry(folder), folder / "geometry.npz"
    flow = read_flow(folder)
    with as_written(path):
        source, target, k = (int(number) for number in arrays["window"])
        if len(arrays["vertices"]) != 2 * k - 1 or len(arrays["face_uv"]) not in (0, len(arrays["faces"])):
            raise ValueError(f"it holds {len(arrays['vertices'])} steps of a window of {k}")
        lengths = (arrays["vertices"].shape[1], len(arrays["uv"]))
        if flow is not None and (len(flow.reference), len(flow.uv_flow) or lengths[1]) != lengths:
            raise ValueError("its flow is of another surface")
    names = [step_name(step) for step in range(-k + 1, k)]
    suffix = _suffix(folder, names[0])
    with as_written(folder):
        textures = tuple((folder / (name + suffix)).read_bytes() for name in names) if suffix else ()
    return Transition(
        source,
        target,
        k,
        arrays["vertices"],
        arrays["faces"],
        arrays["uv"],
        arrays["face_uv"],
        textures,
        suffix,
        arrays.get("colors"),
        PlanarRigid(*(float(number) for number in arrays["alignment"])),
        _read_card(folder),
        flow,
        (int(arrays["ends"][0]), int(arrays["ends"][1])) if "ends" in arrays else None,
    )


def read_card(folder: Path) -> tuple[PlanarRigid, dict[str, Any]]:
    """Only the alignment and the quality card of what ``write_transition`` wrote: what the graph needs."""
    arrays = read_arrays(folder / "geometry.npz", {"alignment": _GEOMETRY["alignment"]})
    return PlanarRigid(*(float(number) for number in arrays["alignment"])), _read_card(folder)


def _read_card(folder: Path) -> dict[str, Any]:
    card = read_json(folder / "card.json")
    with as_written(folder / "card.json"):
        if not isinstance(card, dict):
            raise ValueError("it is no object")
    return card


def _read_geometry(folder: Path) -> dict[str, np.ndarray]:
    arrays = read_arrays(folder / "geometry.npz", _GEOMETRY, _OPTIONAL)
    with as_written(folder / "geometry.npz"):
        for name in ("vertices", "uv", "alignment"):
            if not np.isfinite(arrays[name]).all():
                raise ValueError(f"{name} holds numbers that are not finite")
    return arrays


def read_floor_centres(folder: Path) -> np.ndarray:
    """(2k-1, 2) float64: the floor centre of each step of what ``write_transition`` wrote, in the source's place."""
    arrays = _read_geometry(folder)
    return np.stack([floor_centre(vertices, arrays["faces"]) for vertices in arrays["vertices"]])
