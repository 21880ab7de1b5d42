"""The root's velocity: a shape alone does not tell walking from walking on the spot.

Descriptors are about each frame's own axis and so blind to travel. Were the windows compared as they lie in the room,
with only their centres' axes put together, the frames l away from the centre would be apart by l / fps |v_s - R(yaw)
v_t| more, for velocities v: sum_l w_l (l / fps)^2 |v_s - R v_t|^2 in a mean of squares. That is the term added to
squared scores, with a fixed time tau (``velocity_seconds``) in place of the window's own sqrt(sum_l w_l (l / fps)^2),
which is 0.086 s at k = 10 and 30 frames a second, so that it weighs the same at any frame rate. Scores that are not in
metres take it in the proportion of the descriptors' thresholds.
"""

import numpy as np


def root_velocities(roots: np.ndarray, weights: np.ndarray, fps: float) -> np.ndarray:
    """``(n,) complex128``, x + i y in metres a second: slope of the line fitted to the window about each frame.

    ``roots`` (n, 2) in metres; the fit is by least squares with the window's ``weights`` (2 k + 1,). NaN within k of
    the ends. Windows that span the end of a clip are not told apart here: their scores are never asked for.
    """
    velocities = np.full(len(roots), np.nan + 0j)
    k = len(weights) // 2
    if len(roots) > 2 * k:
        steps = np.arange(-k, k + 1)
        moments = weights * steps
        slopes = np.correlate(roots[:, 0] + 1j * roots[:, 1], moments + 0j, mode="valid") / (moments @ steps)
        velocities[k : len(roots) - k] = slopes * fps
    return velocities
