"""A transition on disk: arrays, one image a step, and the quality card."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.geometry.centre import floor_centre
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.texture_flow import TextureFlow
from unstructured_mg.synthesis.transition import Transition

# The images of steps -k and k.
END_NAMES = ("start", "end")


def step_name(step: int) -> str:
    """``step_-09``, ``step_00``, ``step_09``: the stem of a step's image."""
    return f"step_{step:03d}" if step < 0 else f"step_{step:02d}"


def write_transition(transition: Transition, folder: Path) -> None:
    """Write ``geometry.npz``, ``card.json`` and, where there are textures, ``step_-09.jpg`` ... into ``folder``.

    Where there is a flow, ``flow.npz`` holds it, with ``start.jpg`` and ``end.jpg`` beside it where there are images.

    ``geometry.npz`` (never pickled) holds ``vertices``, ``faces``, ``uv``, ``face_uv``, ``alignment`` (yaw in
    radians, x and y in metres), ``window`` (source, target, k) and, where there are any, ``colors``. ``card.json`` is
    the quality card.
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
    with np.load(folder / "flow.npz", allow_pickle=False) as arrays:
        return TextureFlow(
            arrays["reference"],
            arrays["displacement"],
            arrays["uv_flow"],
            tuple((folder / (name + suffix)).read_bytes() for name in END_NAMES) if suffix else (),
            suffix,
            arrays["colors"] if "colors" in arrays.files else None,
        )


def _suffix(folder: Path, name: str) -> str:
    """The ending of the image ``name`` in ``folder``, empty where there is none."""
    return next((suffix for suffix in (".jpg", ".png") if (folder / (name + suffix)).exists()), "")


def read_transition(folder: Path) -> Transition:
    """Read what ``write_transition`` wrote. Raises OSError or ValueError where a file is missing or damaged."""
    with np.load(folder / "geometry.npz", allow_pickle=False) as arrays:
        source, target, k = (int(number) for number in arrays["window"])
        names = [step_name(step) for step in range(-k + 1, k)]
        suffix = _suffix(folder, names[0])
        return Transition(
            source,
            target,
            k,
            arrays["vertices"],
            arrays["faces"],
            arrays["uv"],
            arrays["face_uv"],
            tuple((folder / (name + suffix)).read_bytes() for name in names) if suffix else (),
            suffix,
            arrays["colors"] if "colors" in arrays.files else None,
            PlanarRigid(*(float(number) for number in arrays["alignment"])),
            json.loads((folder / "card.json").read_text()),
            read_flow(folder),
        )


def read_card(folder: Path) -> tuple[PlanarRigid, dict[str, Any]]:
    """Only the alignment and the quality card of what ``write_transition`` wrote: what the graph needs."""
    with np.load(folder / "geometry.npz", allow_pickle=False) as arrays:
        alignment = PlanarRigid(*(float(number) for number in arrays["alignment"]))
    return alignment, json.loads((folder / "card.json").read_text())


def read_floor_centres(folder: Path) -> np.ndarray:
    """(2k-1, 2) float64: the floor centre of each step of what ``write_transition`` wrote, in the source's place."""
    with np.load(folder / "geometry.npz", allow_pickle=False) as arrays:
        faces = arrays["faces"]
        return np.stack([floor_centre(vertices, faces) for vertices in arrays["vertices"]])
