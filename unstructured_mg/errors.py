"""The errors and refusals that cross a room's border."""

from dataclasses import dataclass, field


class UserError(Exception):
    """Something only the user can mend. The text is one sentence: the file, what is wrong, what to do."""


@dataclass(frozen=True)
class FrameFault:
    """A frame that cannot be used, and why.

    ``clip`` and ``number`` name the frame as its id does; ``file`` is the path as the user knows it.
    """

    clip: str
    number: int
    file: str
    fault: str
    remedy: str


@dataclass(frozen=True)
class Refusal:
    """Why a candidate pair did not become a transition: an expected outcome, so returned and never raised.

    ``stage`` is the room that refused ("tracking" or "synthesis"); ``reason`` is a sentence for the report;
    ``measures`` holds the numbers behind it.
    """

    stage: str
    reason: str
    measures: dict[str, float] = field(default_factory=dict)
