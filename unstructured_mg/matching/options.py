"""What matching can be told."""

from dataclasses import dataclass

from unstructured_mg.matching.descriptors import DESCRIPTORS

WINDOWS = ("fixed", "adaptive")


@dataclass(frozen=True)
class MatchingOptions:
    """Options of the matching room; the defaults are those of P A.1 unless a line says otherwise.

    Attributes
    ----------
    descriptor : name in ``descriptors.DESCRIPTORS``
    resolution : N; 2 N yaws are compared, and the cylindrical grid has 2 N angles, N / 2 radii and N heights. A
        multiple of 8, at least 16; None is the descriptor's own. Where time or disk is short, 32 gave the scores of 64
        within 0.4 mm, and yaws within 0.2 degrees, at an eighth of the work. Deformation gradients have none
    rank : for long captures: each frequency of a frame is described by so many numbers (see ``low_rank.py``); None is
        all of them, exactly. Not for deformation gradients, which are short. Not in P.
    windows : "fixed" (P) or "adaptive" (H equations 4 and 5), see ``compute_dissimilarity``
    k : frames either side of a window's centre; a window has 2 k + 1 frames. Of adaptive windows, the smallest
    largest_k : of adaptive windows, the largest k; None is 2 k
    velocity_seconds : weight of the difference of root velocities (see ``velocity.py``); 0 leaves it out. Not in P. On
        two registered captures without travel 0.1 ranks pairs as well as 0 (areas under the ROC 0.995 and 0.9995 to
        0.997 and 0.999), 0.2 worse (0.975 and 0.978); 0.1 suffices to tell walking from walking on the spot
    colour_m : metres of distance that the largest difference of a colour channel counts for; 0 leaves colour out. For
        descriptors that can take it in, at about twice the time for the pairs. Not in P. With a pattern painted on
        registered captures 0.1 ranks pairs better (0.999 and 0.9996); light that stays behind when the actor turns is
        not in that, so it is left out unless asked for
    minimum_gap_seconds : source and target of a pair in one clip are at least this far apart (P: 60 frames at 30), and
        always so far that their windows share no frame
    loops : whether pairs closer than that count where the motion between them went away and came back (see
        ``loops.py``). Not in P.
    separation_seconds : two transitions whose sources and whose targets are both closer than this are near (P: 20
        frames)
    threshold : a pair is a candidate where its score is at most this: a share of the actor's size where scores are in
        metres, else in the scores' unit (see ``match``). None is the descriptor's own. Not in P.
    alternatives : how many pairs near each chosen one are listed beside it, for when it is refused. Not in P.
    nearest : how many of the best pairs are listed whatever their score. Not in P.
    """

    descriptor: str = "cylindrical_edt"
    resolution: int | None = None
    rank: int | None = None
    windows: str = "fixed"
    k: int = 10
    largest_k: int | None = None
    velocity_seconds: float = 0.1
    colour_m: float = 0.0
    minimum_gap_seconds: float = 2.0
    loops: bool = True
    separation_seconds: float = 20 / 30
    threshold: float | None = None
    alternatives: int = 3
    nearest: int = 8

    def __post_init__(self) -> None:
        if self.descriptor not in DESCRIPTORS:
            raise ValueError(f"descriptor: expected one of {', '.join(sorted(DESCRIPTORS))}, got {self.descriptor!r}")
        descriptor = DESCRIPTORS[self.descriptor]
        if self.resolution is not None:
            if descriptor.resolution is None:
                raise ValueError(f"resolution: expected none for {self.descriptor}, got {self.resolution}")
            if self.resolution < 16 or self.resolution % 8:
                raise ValueError(f"resolution: expected a multiple of 8, at least 16, got {self.resolution}")
        if self.rank is not None:
            if descriptor.resolution is None:
                raise ValueError(f"rank: expected none for {self.descriptor}, got {self.rank}")
            if self.rank < 1:
                raise ValueError(f"rank: expected at least 1, got {self.rank}")
        if self.windows not in WINDOWS:
            raise ValueError(f"windows: expected one of {', '.join(WINDOWS)}, got {self.windows!r}")
        if self.k < 1:
            raise ValueError(f"k: expected at least 1, got {self.k}")
        if self.largest_k is not None:
            if self.windows != "adaptive":
                raise ValueError(f"largest_k: expected none for {self.windows} windows, got {self.largest_k}")
            if self.largest_k < self.k:
                raise ValueError(f"largest_k: expected at least k = {self.k}, got {self.largest_k}")
        for name in ("velocity_seconds", "colour_m", "minimum_gap_seconds", "threshold"):
            value = getattr(self, name)
            if value is not None and not 0 <= value < float("inf"):
                raise ValueError(f"{name}: expected a number from 0 up, got {value}")
        if self.colour_m and not descriptor.colour:
            raise ValueError(f"colour_m: expected 0 for {self.descriptor}, which has no colours, got {self.colour_m}")
        if not 0 < self.separation_seconds < float("inf"):
            raise ValueError(f"separation_seconds: expected a positive number, got {self.separation_seconds}")
        for name in ("alternatives", "nearest"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name}: expected 0 or more, got {getattr(self, name)}")
