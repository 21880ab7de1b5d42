"""How far a blend has come at each step of a transition."""

from collections.abc import Callable

import numpy as np


def linear_weights(k: int) -> np.ndarray:
    """``(2k+1,) float64``: (i + k) / 2k for steps i = -k .. k."""
    return np.arange(2 * k + 1) / (2 * k)


def cubic_weights(k: int) -> np.ndarray:
    """``(2k+1,) float64``: 3 x^2 - 2 x^3 of the linear weight x (P section 6.4).

    Its slope is 0 at both ends, so the transition keeps the captured velocity there.
    """
    x = linear_weights(k)
    return x * x * (3 - 2 * x)


WEIGHTS: dict[str, Callable[[int], np.ndarray]] = {"cubic": cubic_weights, "linear": linear_weights}
