"""Actions that repeat inside a clip: a frame to which the motion returns after it went away.

The least gap between source and target (P A.1) keeps pairs of a slow or still actor out, which resemble each other only
because nothing happened between. It also keeps out what repeats sooner, such as a walk's single cycle. These are told
apart by what lies between: in a loop there is a moment unlike both ends.
"""

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.matching.dissimilarity import Dissimilarity


def short_loops(capture: Capture, dissimilarity: Dissimilarity, threshold: float, gap: float) -> np.ndarray:
    """``(n, n) bool``: pairs s < t of one run, fewer than ``gap`` frames but at least 2 k + 1 apart, that score at most
    ``threshold`` and between which the motion ``departs``.
    """
    scores, k = dissimilarity.scores, dissimilarity.k
    n = len(scores)
    found = np.zeros((n, n), bool)
    if not k.any():
        return found
    run = np.repeat(np.arange(len(capture.runs())), [len(run) for run in capture.runs()])
    for lag in range(2 * int(k[k > 0].min()) + 1, min(int(np.ceil(gap)), n)):
        source = np.arange(n - lag)
        ends = scores[source, source + lag]
        likely = (ends <= threshold) & (lag >= 2 * k[source, source + lag] + 1) & (run[source] == run[source + lag])
        for s in np.flatnonzero(likely):
            found[s, s + lag] = departs(scores, int(s), int(s) + lag, threshold)
    return found


def departs(scores: np.ndarray, source: int, target: int, threshold: float) -> bool:
    """Whether a frame between two is farther than ``threshold``, and twice as far as they are, from both of them."""
    between = np.minimum(scores[source, source:target], scores[source:target, target])
    away = np.fmax.reduce(between)
    return bool(away > threshold and away > 2 * scores[source, target])
