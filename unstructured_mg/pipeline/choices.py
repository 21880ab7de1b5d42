"""``pairs.json``: what the user wants of certain pairs, pinned or vetoed, whatever the ranking says."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.matching.match import Matching

CHOICES_FILE = "pairs.json"
REMEDY = "mend it or take it away"


@dataclass(frozen=True)
class Choices:
    """Pairs of frame indices, the lesser first.

    ``pins`` are tried first, in this order, however unlike and however near to others they are. Tracking and synthesis
    may still refuse them. ``vetoes`` count as refused, so that a pair near them is tried in their place.
    """

    pins: tuple[tuple[int, int], ...] = ()
    vetoes: tuple[tuple[int, int], ...] = ()


NO_CHOICES = Choices()


def read_choices(path: Path, capture: Capture, max_pairs: int | None) -> Choices:
    """Read ``pairs.json``; nothing is chosen where there is no such file.

    Raises UserError where it is not what docs/files.md describes, or names a frame that is not there.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        return NO_CHOICES
    except (OSError, ValueError, RecursionError):
        raise UserError(f"{path}: it is not readable as JSON; {REMEDY}.") from None
    if not isinstance(content, dict) or not content.keys() <= {"pins", "vetoes"}:
        raise UserError(f'{path}: expected an object with the keys "pins" and "vetoes" alone; {REMEDY}.')
    pins, vetoes = (_pairs(path, capture, key, content.get(key, [])) for key in ("pins", "vetoes"))
    both = [pair for pair in pins if pair in vetoes]
    if both:
        raise UserError(f"{path}: {_name(capture, both[0])} is both pinned and vetoed; take it out of one of them.")
    if max_pairs is not None and len(pins) > max_pairs:
        raise UserError(
            f"{path}: {len(pins)} pairs are pinned, and at most {max_pairs} may be kept; raise --max-pairs."
        )
    return Choices(pins, vetoes)


def chosen_candidates(choices: Choices, matching: Matching, capture: Capture, path: Path) -> tuple[Candidate, ...]:
    """The pinned pairs, then all other candidates, best first; UserError where no transition can join a pinned pair."""
    scores, yaw = matching.dissimilarity.scores, matching.dissimilarity.yaw
    pinned = []
    for source, target in choices.pins:
        k = int(matching.dissimilarity.k[source, target])
        first, second = capture.frames[source], capture.frames[target]
        if not math.isfinite(scores[source, target]):
            raise UserError(
                f"{path}: {_name(capture, (source, target))} do not both have a whole window about them; "
                "pin frames further from gaps and ends."
            )
        if first.clip == second.clip and second.number - first.number < 2 * k + 1:
            raise UserError(
                f"{path}: the windows of {_name(capture, (source, target))} share frames; "
                f"pin frames that are at least {2 * k + 1} apart."
            )
        pinned.append(Candidate(source, target, float(scores[source, target]), float(yaw[source, target]), k))
    others = (c for c in matching.candidates if (c.source, c.target) not in choices.pins)
    return (*pinned, *others)


def _pairs(path: Path, capture: Capture, key: str, rows: Any) -> tuple[tuple[int, int], ...]:
    if not isinstance(rows, list):
        raise UserError(f'{path}: "{key}" is not a list of pairs; {REMEDY}.')
    pairs = []
    for place, row in enumerate(rows, 1):
        if not isinstance(row, list) or len(row) != 2 or not all(isinstance(name, str | int) for name in row):
            raise UserError(f'{path}: number {place} of "{key}" is not a pair of frames like ["12", "140"]; {REMEDY}.')
        try:
            source, target = sorted(capture.index_of(str(name)) for name in row)
        except UserError as error:
            raise UserError(f'{path}: number {place} of "{key}": {error}') from None
        pairs.append((source, target))
    return tuple(dict.fromkeys(pairs))


def _name(capture: Capture, pair: tuple[int, int]) -> str:
    return f"{capture.frame_id(pair[0])} and {capture.frame_id(pair[1])}"
