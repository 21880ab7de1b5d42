"""How often each captured frame is wanted in a random walk."""

import math
from collections.abc import Sequence

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError


def check_wish(wish: str) -> tuple[str, float]:
    """What a wish, ``WHAT=WEIGHT``, is about, and its weight; ValueError where it says no such thing."""
    what, sign, number = wish.rpartition("=")
    try:
        weight = float(number)
    except ValueError:
        weight = math.nan
    if not sign or not what or not 0 < weight < math.inf:
        raise ValueError(f"visits: expected WHAT=WEIGHT with a positive number, such as walk=2, got {wish!r}")
    return what, weight


def target_weights(capture: Capture, wishes: Sequence[str]) -> np.ndarray:
    """(n,) float64 weights of the captured frames: 1, or what the last wish about a frame says.

    A wish is ``CLIP=WEIGHT``, ``FRAME=WEIGHT`` or ``FRAME..FRAME=WEIGHT`` with ids of frames in the capture's order.

    Raises
    ------
    UserError
        Where a wish names neither a clip nor a frame.
    """
    weights = np.ones(len(capture))
    clips = np.array([frame.clip for frame in capture.frames])
    for wish in wishes:
        what, weight = check_wish(wish)
        if what in capture.clips and what:
            weights[clips == what] = weight
            continue
        first, dots, last = what.partition("..")
        begin, end = capture.index_of(first), capture.index_of(last if dots else first)
        if end < begin:
            raise UserError(f"{wish}: frame {last} comes before frame {first}; give the earlier one first.")
        weights[begin : end + 1] = weight
    return weights
