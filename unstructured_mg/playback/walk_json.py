"""walk.json: where each exported frame came from and how it was placed (docs/files.md)."""

import json
from collections.abc import Mapping
from typing import Any

from unstructured_mg.capture.capture import Capture
from unstructured_mg.playback.walk import Walk
from unstructured_mg.playback.world import ExportSpace

FORMAT_VERSION = 1


def walk_to_json(
    walk: Walk,
    capture: Capture,
    space: ExportSpace,
    files: list[str] | None = None,
    inputs: Mapping[str, str] | None = None,
    fps: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """JSON-ready. ``files`` names each frame's file, ``inputs`` what the walk was made from (name to content hash).

    ``fps`` is the export's where it is not the capture's, ``options`` what was asked of the export.
    """
    name = capture.frame_id
    frames = []
    for index, frame in enumerate(walk.frames):
        entry: dict[str, Any] = {} if files is None else {"file": files[index]}
        entry["source"] = frame.source
        if frame.transition is not None:
            entry["transition"] = {"source": name(frame.transition[0]), "target": name(frame.transition[1])}
            entry["step"] = frame.step
        elif frame.frame is not None:
            entry["frame"] = name(frame.frame)
        entry["world"] = space.world(frame.world).tolist()
        frames.append(entry)
    return {
        "format": "unstructured_mg walk",
        "version": FORMAT_VERSION,
        "fps": float(capture.fps if fps is None else fps),
        "unit": float(space.unit),
        "up": space.up,
        "floor": float(space.floor),
        "kind": walk.kind,
        "seed": walk.seed,
        "generator": "sfc32" if walk.kind == "random" else None,
        "start": name(walk.start),
        "goal": None if walk.goal is None else name(walk.goal),
        "ended": walk.ended,
        "remark": walk.remark,
        "again": None if walk.again is None else space.world(walk.again).tolist(),
        "inputs": dict(inputs or {}),
        "options": dict(options or {}),
        "frames": frames,
    }


def walk_text(data: Mapping[str, Any]) -> str:
    """The JSON text, one frame a line, so that a person can read it and a diff shows single frames."""
    head = json.dumps({key: value for key, value in data.items() if key != "frames"}, indent=1)
    frames = ",\n".join("  " + json.dumps(frame) for frame in data["frames"])
    return f'{head[:-2]},\n "frames": [\n{frames}\n ]\n}}\n'
