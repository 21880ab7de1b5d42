"""Where the actor stands in each frame: what distances and floor curves are measured on."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Places:
    """Centres of the body's surface on the floor, metres.

    Attributes
    ----------
    captured : (n, 2) float64, of every captured frame, in its captured place
    steps : for each link, in the links' order, (2k-1, 2) float64 of its steps, in its source's captured place
    """

    captured: np.ndarray
    steps: tuple[np.ndarray, ...]
