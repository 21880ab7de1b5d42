"""JSON manifests of captures: found in a folder, read, and their paths resolved."""

import json
from pathlib import Path
from typing import Any

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.paths import capture_roots, find_named
from unstructured_mg.capture.sidecar import NAMES

LARGEST = 1 << 26
_REMEDY = "mend the manifest, or export the capture again"


def read_manifest(path: Path) -> dict[str, Any]:
    """The JSON object in ``path``. Raises FrameError where it is not one."""
    try:
        data = json.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        raise FrameError(path, "it is not readable as JSON", _REMEDY) from None
    if not isinstance(data, dict):
        raise FrameError(path, "it does not hold a JSON object", _REMEDY)
    return data


def find_manifests(folder: Path, names: list[str]) -> list[Path]:
    """Of the files of these names those that may be a manifest: JSON, not the capture's own sidecar, not too large."""
    paths = [
        folder / name for name in names if name.lower().endswith((".json", ".uvol", ".manifest")) and name not in NAMES
    ]
    return [path for path in paths if path.is_file() and 0 < path.stat().st_size <= LARGEST]


def file_in(path: Path, folder: Path, name: str, what: str) -> Path:
    """The file that ``name`` in the manifest ``path`` means. Raises FrameError where there is none."""
    file = find_named(name, path, capture_roots(path, folder))
    if file is None:
        raise FrameError(path, f'its {what} "{name}" is not there', "copy that file too, or mend the manifest")
    return file


def positive(path: Path, value: Any, what: str, most: float) -> float:
    """``value`` as a number above 0 and at most ``most``. Raises FrameError for anything else."""
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            value = None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value <= most:
        raise FrameError(path, f"expected a number above 0 and at most {most:g} for {what}, found {value!r}", _REMEDY)
    return float(value)
