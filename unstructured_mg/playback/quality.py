"""A quality card as rows of a table."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from unstructured_mg.playback.svg import number


@dataclass(frozen=True)
class QualityRow:
    """One measure: ``limit`` and ``verdict`` ("good", "poor" or "") are empty where nothing is demanded of it."""

    name: str
    value: str
    limit: str = ""
    verdict: str = ""


def quality_rows(card: Mapping[str, Any]) -> list[QualityRow]:
    """The rows of a card, in its order; a group's name goes before its measures' names."""
    return _rows(card, "")


def _rows(card: Mapping[str, Any], group: str) -> list[QualityRow]:
    rows: list[QualityRow] = []
    for key, entry in card.items():
        name = f"{group}{key.replace('_', ' ')}"
        if isinstance(entry, Mapping) and "value" in entry:
            limit = entry.get("limit", entry.get("threshold"))
            holds = entry.get("holds", entry.get("ok"))
            verdict = "" if holds is None else "good" if holds else "poor"
            rows.append(QualityRow(name, _text(entry["value"]), "" if limit is None else _text(limit), verdict))
        elif isinstance(entry, Mapping):
            rows += _rows(entry, f"{name}: ")
        else:
            rows.append(QualityRow(name, _text(entry)))
    return rows


def _text(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool | int | float):
        return number(value)
    if isinstance(value, list | tuple):
        return ", ".join(_text(each) for each in value)
    return str(value)
