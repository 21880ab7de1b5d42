"""What matching can be told."""

from dataclasses import dataclass

from unstructured_mg.matching.descriptors import DESCRIPTORS


@dataclass(frozen=True)
class MatchingOptions:
    """Options of the matching room; the defaults are those of P A.1 unless a line says otherwise.

    Attributes
    ----------
    descriptor : name in ``descriptors.DESCRIPTORS``
    resolution : N; the grid has 2 N angles, N / 2 radii and N heights. A multiple of 8, at least 16. Where time or disk
        is short, 32 gave the scores of 64 within 0.4 mm, and yaws within 0.2 degrees, at an eighth of the work
    k : frames either side of a window's centre; a window has 2 k + 1 frames
    velocity_seconds : weight of the difference of root velocities (see ``velocity.py``); 0 leaves it out. Not in P.
    minimum_gap_seconds : source and target of a pair in one clip are at least this far apart (P: 60 frames at 30), and
        always so far that their windows share no frame
    separation_seconds : two transitions whose sources and whose targets are both closer than this are near (P: 20
        frames)
    threshold_size : a pair is a candidate where its score is at most this share of the actor's size (see ``match``).
        Not in P.
    alternatives : how many pairs near each chosen one are listed beside it, for when it is refused. Not in P.
    nearest : how many of the best pairs are listed whatever their score. Not in P.
    """

    descriptor: str = "cylindrical_edt"
    resolution: int = 64
    k: int = 10
    velocity_seconds: float = 0.1
    minimum_gap_seconds: float = 2.0
    separation_seconds: float = 20 / 30
    threshold_size: float = 0.04
    alternatives: int = 3
    nearest: int = 8

    def __post_init__(self) -> None:
        if self.descriptor not in DESCRIPTORS:
            raise ValueError(f"descriptor: expected one of {', '.join(sorted(DESCRIPTORS))}, got {self.descriptor!r}")
        if self.resolution < 16 or self.resolution % 8:
            raise ValueError(f"resolution: expected a multiple of 8, at least 16, got {self.resolution}")
        if self.k < 1:
            raise ValueError(f"k: expected at least 1, got {self.k}")
        for name in ("velocity_seconds", "minimum_gap_seconds", "threshold_size"):
            if not 0 <= getattr(self, name) < float("inf"):
                raise ValueError(f"{name}: expected a number from 0 up, got {getattr(self, name)}")
        if not 0 < self.separation_seconds < float("inf"):
            raise ValueError(f"separation_seconds: expected a positive number, got {self.separation_seconds}")
        for name in ("alternatives", "nearest"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name}: expected 0 or more, got {getattr(self, name)}")
