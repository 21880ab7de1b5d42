"""A quality card as rows of a table, with the limits that it was judged by."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from unstructured_mg.playback.svg import length, number, percent
from unstructured_mg.synthesis.options import SynthesisOptions

GOOD, POOR = "good", "poor"


@dataclass(frozen=True)
class QualityRow:
    """One measure: ``limit`` and ``verdict`` (GOOD, POOR or "") are empty where nothing is demanded of it."""

    name: str
    value: str
    limit: str = ""
    verdict: str = ""


def _levels(value: float) -> str:
    return f"{value:.3g} / 255"


def _times(value: float) -> str:
    return f"{value:.3g} ×"


# What is judged as a ratio to the capture's own change: key, ending of the key of its size, format of the size.
_JUMPS: tuple[tuple[str, str, Callable[[float], str]], ...] = (
    ("surface", "_m", length),
    ("velocity", "_m", length),
    ("colour", "_levels", _levels),
)
# Name, format and the option that limits it from above.
_MEASURES: dict[str, tuple[str, Callable[[Any], str], str]] = {
    "volume_drift": ("volume drift", percent, "volume_drift"),
    "inverted_tets": ("cage cells inside out", number, "inverted_tets"),
    "self_intersections": ("more faces that cut others", percent, "self_intersections"),
    "foot_slide_m": ("slide of planted feet", length, "foot_slide"),
    "surface_change_m": ("change of surface in the capture", length, ""),
    "velocity_change_m": ("change of velocity in the capture", length, ""),
    "colour_change_levels": ("change of colour in the capture", _levels, ""),
    "speed_m": ("largest motion in the capture, a frame", length, ""),
    "holes_start": ("texture without a source, first seam", percent, ""),
    "holes_end": ("texture without a source, last seam", percent, ""),
    "flow_residual_before": ("difference of textures before flow", _levels, ""),
    "flow_residual_after": ("difference of textures after flow", _levels, ""),
    "flow_unexplained": ("texture that flow does not explain", percent, ""),
}
# The card's jumps of colour, once more.
_REPEATED = ("seam_color_start", "seam_color_end")


def quality_rows(card: Mapping[str, Any], limits: SynthesisOptions) -> list[QualityRow]:
    """The rows of a card in reading order: what is judged, what the capture itself does, then the rest of the card.

    The verdicts are those by which ``synthesis.quality.objections`` refuses.
    """
    rows = [
        _jump(f"{key}, {name}", card[seam], key, ending, text, limits)
        for key, ending, text in _JUMPS
        for seam, name in (("start", "first seam"), ("end", "last seam"))
        if key in card.get(seam, {})
    ]
    rest = {**card, **card.get("texture", {})}
    sharpness = rest.pop("sharpness", None)
    if sharpness is not None:
        verdict = GOOD if sharpness >= limits.sharpness else POOR
        least = f"at least {_times(limits.sharpness)}"
        rows.append(QualityRow("sharpness of the middle to the ends", _times(sharpness), least, verdict))
    for key in ("texture", *_REPEATED):
        rest.pop(key, None)
    judged = {name for key, ending, _ in _JUMPS for name in (key, key + ending)}
    for seam in ("start", "end"):
        rest[seam] = {key: value for key, value in card.get(seam, {}).items() if key not in judged}
    known = [key for key in _MEASURES if key in rest]
    for key in known:
        name, text, option = _MEASURES[key]
        rows.append(_limited(name, rest[key], text, getattr(limits, option) if option else None))
    return rows + plain_rows({key: value for key, value in rest.items() if key not in known})


def plain_rows(measures: Mapping[str, Any], group: str = "") -> list[QualityRow]:
    """Rows of measures by their keys; a group's name goes before its measures' names.

    A key that ends in ``_m`` is in metres; one that stands beside the same key with ``_m`` is a ratio to the capture's
    own.
    """
    rows: list[QualityRow] = []
    for key, value in measures.items():
        name = group + key.removesuffix("_m").replace("_", " ")
        if isinstance(value, Mapping):
            rows += plain_rows(value, f"{name}: ")
        elif key.endswith("_m") and isinstance(value, int | float):
            rows.append(QualityRow(name, length(value)))
        elif f"{key}_m" in measures and isinstance(value, int | float):
            rows.append(QualityRow(name, _times(value)))
        else:
            rows.append(QualityRow(name, _plain(value)))
    return rows


def _jump(
    name: str, seam: Mapping[str, Any], key: str, ending: str, text: Callable[[float], str], limits: SynthesisOptions
) -> QualityRow:
    """A jump is judged as a ratio to the capture's own change, and not at all where it is tiny."""
    ratio, size = seam[key], seam[key + ending]
    largest, floor = getattr(limits, f"{key}_jump"), getattr(limits, f"{key}_jump_floor")
    if size is None:
        return QualityRow(name, "not measured")
    good = size <= floor or (ratio is not None and ratio <= largest)
    value = text(size) if ratio is None else f"{_times(ratio)} ({text(size)})"
    return QualityRow(name, value, f"{_times(largest)} or {text(floor)}", GOOD if good else POOR)


def _limited(name: str, value: Any, text: Callable[[Any], str], limit: float | None) -> QualityRow:
    if value is None:
        return QualityRow(name, "not measured", "" if limit is None else text(limit))
    if limit is None:
        return QualityRow(name, text(value))
    return QualityRow(name, text(value), text(limit), GOOD if value <= limit else POOR)


def _plain(value: Any) -> str:
    if value is None:
        return "not measured"
    if isinstance(value, bool | int | float):
        return number(value)
    if isinstance(value, list | tuple):
        return ", ".join(_plain(each) for each in value)
    return str(value)
