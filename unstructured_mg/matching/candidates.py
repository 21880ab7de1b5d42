"""Candidate pairs, ranked (P A.1). Only ranking: trying and refusing them is the pipeline's loop."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Candidate:
    """A pair of similar windows, centred at frame indices ``source < target``.

    ``yaw`` (radians) turns the target about the vertical so that it best matches the source;
    ``score`` is the windowed dissimilarity after that turn (lower is better).
    """

    source: int
    target: int
    score: float
    yaw: float
