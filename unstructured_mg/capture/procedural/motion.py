"""The procedural figure in motion: its script as joint rotations and positions for every frame.

Channels are interpolated without overshoot and then low-passed in time, so that velocities are continuous; a foot is
either exactly still on the floor or on a smooth arc to its next place, and the body follows:
nothing skates.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from unstructured_mg.capture.procedural.choreography import Action, Footfall, Script, compose
from unstructured_mg.capture.procedural.skeleton import INDEX, REST, chain, place_leg, rotation, swing, unit

FPS = 30
SMOOTHING = 1.7  # frames: standard deviation of the low-pass on the control channels
# How far a hip may be from its ankle: a leg is never quite straight.
LEG = 0.994 * float(
    np.linalg.norm(REST[INDEX["left_knee"]] - REST[INDEX["left_hip"]])
    + np.linalg.norm(REST[INDEX["left_ankle"]] - REST[INDEX["left_knee"]])
)
REST_FOOT_YAW = float(np.arctan2(0.010, 0.134))


@dataclass(frozen=True)
class Motion:
    """A posed skeleton for every frame.

    Attributes
    ----------
    rotations : (frames, joints, 3, 3) float64, from rest to world
    positions : (frames, joints, 3) float64 metres, z up
    yaw : (frames,) float64 radians, heading of the body; 0 faces -y
    planted : (frames, 2) bool, left and right: the ball of the foot stands still on the floor
    actions : the labelled stretches, without gaps
    """

    rotations: np.ndarray
    positions: np.ndarray
    yaw: np.ndarray
    planted: np.ndarray
    actions: tuple[Action, ...]


def choreograph(frames: int, seed: int) -> Motion:
    """The motion's first ``frames`` frames; a longer motion of the same seed starts with the same frames.

    Raises ValueError where ``frames`` < 1.
    """
    if frames < 1:
        raise ValueError(f"frames: expected at least 1, got {frames}")
    script, actions = compose(frames, seed)
    return _pose(script, frames, actions, np.random.Generator(np.random.PCG64([seed, 1])))


def _curves(script: Script, times: np.ndarray) -> dict[str, np.ndarray]:
    """Every channel at whole frames: monotone between keys, then low-passed."""
    curves = {}
    for name, keys in script.keys.items():
        latest: dict[float, float] = {}
        for t, value in sorted(keys, key=lambda key: key[0]):
            latest[round(t, 3)] = value
        knots = np.array(sorted(latest))
        values = np.array([latest[t] for t in knots])
        inside = np.clip(times, knots[0], knots[-1])
        raw = PchipInterpolator(knots, values)(inside) if len(knots) > 1 else np.full(len(times), values[0])
        curves[name] = gaussian_filter1d(raw, SMOOTHING, mode="nearest", truncate=5)
    return curves


def _ease(t: np.ndarray) -> np.ndarray:
    """Minimum jerk from 0 to 1."""
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10 - 15 * t + 6 * t * t)


def _footpath(falls: list[Footfall], times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Place (frames, 2), yaw, height and whether it stands, of one foot."""
    place = np.repeat(falls[0].place[None], len(times), 0)
    yaw = np.full(len(times), falls[0].yaw)
    height = np.zeros(len(times))
    still = np.ones(len(times), bool)
    for before, fall in zip(falls, falls[1:], strict=False):
        t = (times - fall.start) / (fall.end - fall.start)
        s = _ease(t)
        place += s[:, None] * (fall.place - before.place)
        yaw += s * (fall.yaw - before.yaw)
        inside = np.clip(t, 0.0, 1.0)
        distance = float(np.linalg.norm(fall.place - before.place))
        height += (0.035 + 0.08 * min(distance, 0.6)) * 64 * (inside * (1 - inside)) ** 3
        still &= (t <= 0) | (t >= 1)
    return place, yaw, height, still


def _pose(script: Script, frames: int, actions: tuple[Action, ...], draw: np.random.Generator) -> Motion:
    margin = 20
    times = np.arange(-margin, frames + margin, dtype=np.float64)
    c = _curves(script, times)
    # Nobody stands still: breath, and a slow sway of trunk, arms and head that never repeats exactly.
    breath = np.sin(2 * np.pi * times / 52 + draw.uniform(0, 6))

    def drift(size: float, period: float) -> np.ndarray:
        a, b = draw.uniform(0, 2 * np.pi, 2)
        return size * (np.sin(2 * np.pi * times / period + a) + 0.6 * np.sin(2 * np.pi * times / (0.617 * period) + b))

    paths = {side: _footpath(script.feet[side], times) for side in ("left", "right")}
    middle = 0.5 * (paths["left"][0] + paths["right"][0])
    yaw = gaussian_filter1d(0.5 * (paths["left"][1] + paths["right"][1]), 3.0, axis=0, mode="nearest", truncate=5)
    middle = gaussian_filter1d(middle, 3.2, axis=0, mode="nearest", truncate=5)
    up = np.array([0.0, 0.0, 1.0])
    heading = rotation(up, yaw)
    left_way, front_way = heading[:, :, 0], -heading[:, :, 1]

    rad = np.radians
    x_axis, y_axis = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])

    def turned(pitch: np.ndarray, roll: np.ndarray, turn: np.ndarray) -> np.ndarray:
        return rotation(up, rad(turn)) @ rotation(y_axis, rad(roll)) @ rotation(x_axis, rad(pitch))

    local: dict[str, np.ndarray] = {}
    local["pelvis"] = heading @ turned(c["pelvis_pitch"], c["pelvis_roll"] + drift(0.35, 130), c["pelvis_turn"])
    pitch, roll, turn = (
        c["spine_pitch"] + 0.7 * breath + drift(0.4, 97),
        c["spine_roll"] + drift(0.5, 140),
        c["spine_turn"],
    )
    for name in ("spine", "chest"):
        local[name] = turned(0.5 * pitch, 0.5 * roll, 0.5 * turn)
    head = (
        c["head_pitch"] - 0.6 * pitch + drift(1.0, 83),
        c["head_roll"] - 0.5 * roll + drift(0.8, 110),
        c["head_turn"] - 0.4 * turn + drift(1.6, 150),
    )
    for name in ("neck", "head"):
        local[name] = turned(0.5 * head[0], 0.5 * head[1], 0.5 * head[2])
    for side in ("left", "right"):
        _arm(local, c, side, drift, breath)

    lower = c["lower"] - 0.002 * breath
    root = np.zeros((len(times), 3))
    root[:, :2] = (
        middle
        + (c["shift"] + drift(0.003, 170))[:, None] * left_way[:, :2]
        + (c["forward"] + 0.012)[:, None] * front_way[:, :2]
    )
    root[:, 2] = REST[0, 2] - lower

    feet = {}
    for side in ("left", "right"):
        place, foot_yaw, height, still = paths[side]
        turn_foot = rotation(up, foot_yaw - (REST_FOOT_YAW if side == "left" else -REST_FOOT_YAW))
        pitched = turn_foot @ rotation(x_axis, rad(c[f"{side}_heel"]))
        ankle_rest, ball_rest = REST[INDEX[f"{side}_ankle"]], _ball_of(side)
        # The given place is the ankle's in the stance; the foot then turns about its ball.
        ball = np.zeros((len(times), 3))
        ball[:, :2] = place
        ball += turn_foot @ ((ball_rest - ankle_rest) * np.array([1.0, 1.0, 0.0]))
        ball[:, 2] = ball_rest[2] + height + c["hop"]
        ankle = ball + pitched @ (ankle_rest - ball_rest)
        feet[side] = (ankle, pitched, turn_foot, still & (np.abs(c["hop"]) < 1e-9))

    # The pelvis sinks where a leg would be too short.
    for _ in range(3):
        rotations, positions = chain(local, root)
        limit = np.full(len(times), np.inf)
        for side in ("left", "right"):
            hip = positions[:, INDEX[f"{side}_hip"]]
            ankle = feet[side][0]
            flat = np.sum((hip[:, :2] - ankle[:, :2]) ** 2, 1)
            room = ankle[:, 2] + np.sqrt(np.maximum(LEG**2 - flat, 0.01)) - hip[:, 2]
            limit = -_soft_maximum(-limit, -room, 0.02) if np.isfinite(limit).all() else room
        root[:, 2] += -_soft_maximum(-limit, np.zeros(len(times)), 0.02)
    rotations, positions = chain(local, root)
    for side in ("left", "right"):
        ankle, pitched, turn_foot, _ = feet[side]
        sign = 1.0 if side == "left" else -1.0
        pole = turn_foot @ unit(np.array([0.22 * sign, -1.0, 0.0]))
        place_leg(rotations, positions, side, ankle, pitched, turn_foot, pole)
    inside = slice(margin, margin + frames)
    planted = np.stack([feet["left"][3], feet["right"][3]], 1)
    return Motion(rotations[inside], positions[inside], yaw[inside], planted[inside], actions)


def _ball_of(side: str) -> np.ndarray:
    ball = REST[INDEX[f"{side}_toe"]].copy()
    ball[2] = 0.0
    return ball


def _soft_maximum(a: np.ndarray, b: np.ndarray, blend: float) -> np.ndarray:
    h = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.maximum(a, b) + h * h * h * blend / 6


def _arm(
    local: dict[str, np.ndarray],
    c: dict[str, np.ndarray],
    side: str,
    drift: Callable[[float, float], np.ndarray],
    breath: np.ndarray,
) -> None:
    """Clavicle, shoulder, elbow and wrist from the arm's channels."""
    sign = 1.0 if side == "left" else -1.0
    rad = np.radians
    raised = rad(c[f"{side}_raise"] + drift(0.9, 101) + 0.3 * breath)
    reach = rad(c[f"{side}_reach"] + drift(1.0, 123))
    twist = rad(c[f"{side}_twist"])
    bend = rad(c[f"{side}_bend"] + drift(1.2, 89))
    wrist = rad(c[f"{side}_wrist"] + drift(1.2, 71))
    up, x_axis, y_axis = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    hang = np.array([0.0, 0.0, -1.0])
    # Away from the body about y, then towards the front about x.
    direction = (rotation(x_axis, -reach) @ rotation(y_axis, -sign * raised) @ hang[:, None])[..., 0]
    elevation = np.arccos(np.clip(-direction[:, 2], -1, 1))
    shrug = 0.32 * np.maximum(elevation - rad(30), 0.0) ** 2 / (np.maximum(elevation - rad(30), 0.0) + rad(40))
    clavicle = rotation(y_axis, -sign * shrug) @ rotation(up, -sign * 0.12 * np.sin(reach))
    local[f"{side}_clavicle"] = clavicle
    rest_upper = unit(REST[INDEX[f"{side}_elbow"]] - REST[INDEX[f"{side}_shoulder"]])
    rest_lower = unit(REST[INDEX[f"{side}_wrist"]] - REST[INDEX[f"{side}_elbow"]])
    wanted = (np.swapaxes(clavicle, 1, 2) @ direction[..., None])[..., 0]
    turn = rotation(wanted, -sign * twist) @ swing(np.broadcast_to(rest_upper, wanted.shape), wanted)
    local[f"{side}_shoulder"] = turn
    hinge = unit(np.cross(rest_upper, -y_axis))
    rest_bend = float(np.arccos(np.clip(rest_upper @ rest_lower, -1, 1)))
    local[f"{side}_elbow"] = rotation(hinge, bend - rest_bend)
    across = unit(np.cross(rest_lower, hinge))
    local[f"{side}_wrist"] = rotation(across, wrist)
