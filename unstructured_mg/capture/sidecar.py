"""What a capture may say of itself: ``capture.json`` or ``sequence.json`` in its folder."""

import json
import math
from pathlib import Path
from typing import Any

from unstructured_mg.capture.placement import UNITS, UP_AXES
from unstructured_mg.errors import UserError

NAMES = ("capture.json", "sequence.json")


def read_sidecar(folder: Path) -> dict[str, Any]:
    """The keys ``fps``, ``unit`` (metres a unit), ``up`` and ``floor``, checked, as far as a sidecar gives them.

    ``unit`` may be written as a name (m, dm, cm, mm, inch, foot). Other keys are other programs' own and passed over.
    Raises UserError where the file is no JSON object or a value cannot be meant.
    """
    for name in NAMES:
        path = folder / name
        if not path.is_file():
            continue
        try:
            data = json.loads(path.read_text(encoding="utf-8-sig"))
        except (OSError, ValueError, RecursionError):
            raise UserError(f"{path}: it is not readable as JSON; mend it or take it away.") from None
        if not isinstance(data, dict):
            raise UserError(f"{path}: it does not hold a JSON object; mend it or take it away.")
        return {
            key: check(data[key], f"{path}: {key}")
            for key, check in (("fps", check_fps), ("unit", check_unit), ("up", check_up), ("floor", check_floor))
            if data.get(key) is not None
        }
    return {}


def check_fps(value: Any, name: str = "fps") -> float:
    if not _is_number(value) or not 0 < value <= 1000:
        raise UserError(f"{name} is {value!r}; give a number of frames a second above 0 and at most 1000.")
    return float(value)


def check_unit(value: Any, name: str = "unit") -> float:
    if isinstance(value, str) and value in UNITS:
        return UNITS[value]
    if not _is_number(value) or not 1e-6 <= value <= 1e6:
        raise UserError(f"{name} is {value!r}; give one of {', '.join(UNITS)}, or metres a unit as a number above 0.")
    return float(value)


def check_up(value: Any, name: str = "up") -> str:
    if not isinstance(value, str) or value not in UP_AXES:
        raise UserError(f"{name} is {value!r}; give one of {', '.join(UP_AXES)}.")
    return value


def check_floor(value: Any, name: str = "floor") -> float:
    if not _is_number(value):
        raise UserError(f"{name} is {value!r}; give the floor's height along the up axis in the capture's own unit.")
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
