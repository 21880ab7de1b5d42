"""The graph room's options."""

from dataclasses import dataclass

from unstructured_mg.graph.targets import check_wish

CONSTRUCTION_NAMES = ("local_windows", "essential", "surface")


@dataclass(frozen=True)
class GraphOptions:
    """Which transitions there are, and how they are weighed against each other.

    Attributes
    ----------
    construction : "local_windows" (P section 4), "essential" (B section 3) or "surface" (H section 3)
    frame_share : of the essential graph: what a frame counts beside the pose distance (B's alpha), as a share of the
        threshold of matching. Larger values give shorter ways and more transitions
    shortest_seconds, longest_seconds : of the essential graph: bounds of a transition's windows (B: 1/3 to 2 seconds)
    most_candidates : of the essential graph: how many of its transitions, the most used first, may be tried
    probabilities : "choice" (P's objective: visits as wanted against choices alike) or "entropy" (visits as wanted
        against the greatest entropy rate, as a convex programme in edge flows)
    visits : wishes ``WHAT=WEIGHT`` about how often captured frames are visited (see ``targets.py``); all alike without
    alpha : weight of visits as wanted against choices as even as possible, 0 to 1 (P section 7.1: 0.08)
    least_share : smallest probability of an out-edge, as a share of an even choice (0 to 1): with two ways out and 0.1,
        each is taken at least once in twenty times. 0 allows transitions that are never taken; ours, P has none.
    cost_weight : frames that a shortest path may grow by to avoid one unit of a transition's cost; 0 counts frames only
    """

    construction: str = "local_windows"
    frame_share: float = 0.15
    shortest_seconds: float = 1 / 3
    longest_seconds: float = 2.0
    most_candidates: int = 300
    probabilities: str = "choice"
    visits: tuple[str, ...] = ()
    alpha: float = 0.08
    least_share: float = 0.1
    cost_weight: float = 0.0

    def __post_init__(self) -> None:
        if self.construction not in CONSTRUCTION_NAMES:
            known = ", ".join(CONSTRUCTION_NAMES)
            raise ValueError(f"construction: expected one of {known}, got {self.construction!r}")
        if not 0 < self.frame_share < float("inf"):
            raise ValueError(f"frame_share: expected a positive number, got {self.frame_share!r}")
        if not 0 < self.shortest_seconds <= self.longest_seconds < float("inf"):
            raise ValueError(
                f"longest_seconds: expected at least shortest_seconds, {self.shortest_seconds!r}, and that a positive "
                f"number, got {self.longest_seconds!r}"
            )
        if self.most_candidates < 1:
            raise ValueError(f"most_candidates: expected 1 or more, got {self.most_candidates!r}")
        if self.probabilities not in ("choice", "entropy"):
            raise ValueError(f'probabilities: expected "choice" or "entropy", got {self.probabilities!r}')
        for wish in self.visits:
            check_wish(wish)
        for name in ("alpha", "least_share"):
            value = getattr(self, name)
            if not 0 <= value <= 1:
                raise ValueError(f"{name}: expected a number from 0 to 1, got {value!r}")
        if not 0 <= self.cost_weight < float("inf"):
            raise ValueError(f"cost_weight: expected a number of frames, 0 or more, got {self.cost_weight!r}")
