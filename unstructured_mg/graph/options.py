"""The graph room's options."""

from dataclasses import dataclass


@dataclass(frozen=True)
class GraphOptions:
    """How transitions are weighed against each other.

    Attributes
    ----------
    alpha : weight of even visits against even choices, 0 to 1 (P section 7.1: 0.08)
    least_share : smallest probability of an out-edge, as a share of an even choice (0 to 1): with two ways out and 0.1,
        each is taken at least once in twenty times. 0 allows transitions that are never taken; ours, P has none.
    cost_weight : frames that a shortest path may grow by to avoid one unit of a transition's cost; 0 counts frames only
    """

    alpha: float = 0.08
    least_share: float = 0.1
    cost_weight: float = 0.0

    def __post_init__(self) -> None:
        for name in ("alpha", "least_share"):
            value = getattr(self, name)
            if not 0 <= value <= 1:
                raise ValueError(f"{name}: expected a number from 0 to 1, got {value!r}")
        if not 0 <= self.cost_weight < float("inf"):
            raise ValueError(f"cost_weight: expected a number of frames, 0 or more, got {self.cost_weight!r}")
