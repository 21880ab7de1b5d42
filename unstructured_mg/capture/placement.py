"""Which way is up, how long a unit is and where the floor lies, guessed from the frames themselves."""

import math
from dataclasses import dataclass

import numpy as np

#: Metres a unit.
UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "foot": 0.3048}
#: Rotation from capture axes to z up, for each up axis.
UP_AXES = {
    "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "-x": ((0, 1, 0), (0, 0, -1), (-1, 0, 0)),
}

# A person in the frame: standing height in metres that is believed without a warning, and the middle that a guess aims
# at.
_PERSON = (1.2, 2.3)
_PERSON_MIDDLE = 1.7
# Share of a frame's vertices that may be noise or debris below it (and above it).
_NOISE_SHARE = 0.002
# Share of the frames that may be spoilt by larger debris.
_FRAME_SHARE = 0.1
# Difference of logarithmic scores from which one axis is clearly more upright than another.
_CLEAR = math.log(1.3)


@dataclass(frozen=True)
class FrameBounds:
    """Of one frame, along x, y and z of the capture: the lowest and highest vertices, noise apart, and the mean
    vertex.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    centre: tuple[float, float, float]


@dataclass(frozen=True)
class Placement:
    """``unit`` metres a capture unit, ``up`` axis, ``floor`` height along it in capture units, and what was assumed."""

    unit: float
    up: str
    floor: float
    warnings: tuple[str, ...]


def frame_bounds(vertices: np.ndarray) -> FrameBounds:
    """Bounds without the outermost 0.2 % of the vertices at each end of each axis."""
    last = len(vertices) - 1
    low, high = int(_NOISE_SHARE * last), last - int(_NOISE_SHARE * last)
    ordered = np.partition(vertices, [low, high], axis=0)
    return FrameBounds(
        tuple(ordered[low].tolist()), tuple(ordered[high].tolist()), tuple(vertices.mean(axis=0).tolist())
    )


def place(bounds: list[FrameBounds], unit: float | None, up: str | None, floor: float | None) -> Placement:
    """Guess what is not given.

    Up is y or z: the one along which the frames are longer (a person is tallest standing), along which the body's
    middle moves less, and along which one end stays put from frame to frame (feet). Captures whose evidence is weak are
    taken as y up, the custom of OBJ. An axis points down only where both other signs agree: its upper end is steadier
    than its lower one, and most of the body (torso, arms) is below its middle. x up must be given.

    The unit is the one of m, dm, cm, mm that makes the usual height closest to a person's; inch and foot must be given,
    since half a person in centimetres measures the same.

    The floor is the height that a tenth of the frames stays below with all but 0.2 % of its vertices: neither a jump,
    which has most frames or at least a tenth standing, nor debris below the floor in fewer frames than that moves it.
    """
    low = np.array([frame.low for frame in bounds])
    high = np.array([frame.high for frame in bounds])
    centre = np.array([frame.centre for frame in bounds])
    warnings = []
    if up is None:
        up, sure = _guess_up(low, high, centre)
        if not sure:
            warnings.append(f"nothing says clearly which way is up: {up} is taken (--up gives it)")
    axis = "xyz".index(up[-1])
    bottom, top = (-high[:, axis], -low[:, axis]) if up.startswith("-") else (low[:, axis], high[:, axis])
    height = float(np.median(top - bottom))
    if unit is None:
        name = min(("m", "dm", "cm", "mm"), key=lambda name: abs(np.log(UNITS[name] * height / _PERSON_MIDDLE)))
        unit = UNITS[name]
        if not _PERSON[0] <= unit * height <= _PERSON[1]:
            warnings.append(
                f"the frames are {height:.4g} units high, which is no standing person in any unit: {name} is taken, "
                f"{unit * height:.2f} m (--unit gives it)"
            )
    if floor is None:
        floor = float(np.quantile(bottom, _FRAME_SHARE))
    return Placement(unit, up, floor, tuple(warnings))


def _guess_up(low: np.ndarray, high: np.ndarray, centre: np.ndarray) -> tuple[str, bool]:
    """The up axis, and whether the evidence is clear."""
    size = np.median(high - low, axis=0)
    grain = 0.02 * size.max()
    steadier_end = np.minimum(_spread(low), _spread(high))
    # an axis twice as long is as much evidence as a middle that moves a quarter as far
    score = np.log(size + grain) - 0.5 * np.log(_spread(centre) + grain) - 0.5 * np.log(steadier_end + grain)
    axis = 2 if score[2] - score[1] > _CLEAR else 1
    sure = score[axis] - np.delete(score, axis).max() > _CLEAR
    grain *= 0.1  # feet on the floor stay put to millimetres
    steadiness = float(np.log((_spread(low)[axis] + grain) / (_spread(high)[axis] + grain)))
    top_heavy = float(np.median((centre - low) / (high - low + 1e-12), axis=0)[axis] - 0.5)
    # measured on five captures of whole bodies, upright: steadiness -0.15 to -1.3, the sum -0.55 to -1.6
    turned = steadiness > np.log(1.1) and steadiness - 10 * top_heavy > 0.5
    return ("-" if turned else "") + "xyz"[axis], bool(sure)


def _spread(values: np.ndarray) -> np.ndarray:
    """Distance between the 10th and the 90th percentile over the frames."""
    return np.quantile(values, 0.9, axis=0) - np.quantile(values, 0.1, axis=0)
