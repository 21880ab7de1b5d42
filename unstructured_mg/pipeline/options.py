"""Everything that a build can be told."""

from contextlib import suppress
from dataclasses import dataclass, field, fields
from typing import Any

from unstructured_mg.capture.placement import UNITS
from unstructured_mg.capture.sidecar import check_floor, check_fps, check_unit, check_up
from unstructured_mg.errors import UserError
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.synthesis.latent.train import require_torch
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.tracking.options import TrackingOptions


@dataclass(frozen=True)
class BuildOptions:
    """Options of ``umg build``: each room's own, and those of the loop over candidates.

    fps, unit (metres per capture unit), up and floor (capture units along the up axis) override what is found in the
    capture where they are not None. ``retries``: refused candidates near a candidate before it is given up.
    ``max_pairs``: keep at most so many pairs, or None. ``preview``: read decimated frames (see ``preview``).
    """

    fps: float | None = None
    unit: float | None = None
    up: str | None = None
    floor: float | None = None
    matching: MatchingOptions = field(default_factory=MatchingOptions)
    tracking: TrackingOptions = field(default_factory=TrackingOptions)
    synthesis: SynthesisOptions = field(default_factory=SynthesisOptions)
    graph: GraphOptions = field(default_factory=GraphOptions)
    retries: int = 4
    max_pairs: int | None = None
    preview: bool = False


# What the command line calls an option, and where it lives.
NAMES = {
    "descriptor": ("matching", "descriptor"),
    "rank": ("matching", "rank"),
    "windows": ("matching", "windows"),
    "window": ("matching", "k"),
    "largest_window": ("matching", "largest_k"),
    "threshold": ("matching", "threshold"),
    "velocity": ("matching", "velocity_seconds"),
    "colour": ("matching", "colour_m"),
    "cage": ("tracking", "cage"),
    "hausdorff": ("tracking", "hausdorff_m"),
    "blend": ("synthesis", "blend"),
    "weights": ("synthesis", "weights"),
    "texture": ("synthesis", "texture"),
    "graph": ("graph", "construction"),
    "probabilities": ("graph", "probabilities"),
    "visit": ("graph", "visits"),
}
ROOMS = {
    "matching": MatchingOptions,
    "tracking": TrackingOptions,
    "synthesis": SynthesisOptions,
    "graph": GraphOptions,
}


def capture_options(
    fps: float | None, unit: str | None, up: str | None, floor: float | None, prefix: str = "--"
) -> dict[str, Any]:
    """What the command line says of a capture, checked before any frame is read; UserErrors name the option."""
    number: float | str | None = unit
    if unit is not None and unit not in UNITS:
        with suppress(ValueError):  # what is neither a name nor a number is refused below
            number = float(unit)
    checks = (
        ("fps", check_fps, fps),
        ("unit", check_unit, number),
        ("up", check_up, up),
        ("floor", check_floor, floor),
    )
    return {name: None if value is None else check(value, f"{prefix}{name}") for name, check, value in checks}


def build_options(**given: Any) -> BuildOptions:
    """Options from the command line's words; None stands for the default. A value that is no good is a UserError."""
    own = {each.name for each in fields(BuildOptions)} - set(ROOMS)
    rooms: dict[str, dict[str, Any]] = {room: {} for room in ROOMS}
    whole: dict[str, Any] = {}
    for word, value in given.items():
        if value is None:
            continue
        if word in own:
            whole[word] = value
        else:
            room, name = NAMES[word]
            rooms[room][name] = value
    try:
        options = BuildOptions(**whole, **{room: ROOMS[room](**values) for room, values in rooms.items()})
    except ValueError as error:
        name, _, rest = str(error).partition(":")
        words = {option: word for word, (_, option) in NAMES.items()}
        raise UserError(f"--{words.get(name, name).replace('_', '-')}:{rest}.") from None
    if options.synthesis.blend == "latent":
        require_torch()  # now, not after an hour of matching
    return options


def export_options(fps: float | None, unit: str | None, up: str | None, **given: Any) -> ExportOptions:
    """Options of an export from the command line's words. A value that is no good is a UserError."""
    space = capture_options(fps, unit, up, None)
    try:
        return ExportOptions(fps=space["fps"], unit=space["unit"], up=space["up"], **given)
    except ValueError as error:
        name, _, rest = str(error).partition(":")
        raise UserError(f"--{name.replace('_', '-')}:{rest}.") from None
