"""What the procedural figure does: a seeded choreography as joint rotations and positions for every frame.

Every action is written as keys of a few control channels and as footfalls. Channels are interpolated without overshoot
and then low-passed in time, so that velocities are continuous; a foot is either exactly still on the floor or on a
smooth arc to its next place, and the body follows its feet, so that nothing skates.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from unstructured_mg.capture.procedural.skeleton import INDEX, REST, chain, place_leg, rotation, swing, unit

FPS = 30
SMOOTHING = 1.7  # frames: standard deviation of the low-pass on the control channels
FOOT_WIDTH = 0.125  # metres from the middle to each foot in the stance

# What every channel is in the stance; angles in degrees, lengths in metres.
STANCE = {
    "lower": 0.012,  # pelvis below its rest height
    "shift": 0.0,  # pelvis to the left of the middle between the feet
    "forward": 0.0,
    "pelvis_turn": 0.0,
    "pelvis_pitch": 0.0,
    "pelvis_roll": 0.0,
    "spine_pitch": 2.0,  # positive bends forward
    "spine_roll": 0.0,  # positive leans to the left
    "spine_turn": 0.0,  # positive turns to the left
    "head_pitch": 0.0,
    "head_roll": 0.0,
    "head_turn": 0.0,
    "left_raise": 13.0,  # arm away from the body, 0 hangs, 90 level
    "left_reach": 2.0,  # arm towards the front, 90 level
    "left_twist": 0.0,  # turns the bend of the elbow outwards and up
    "left_bend": 16.0,
    "left_wrist": 0.0,
    "right_raise": 13.0,
    "right_reach": 2.0,
    "right_twist": 0.0,
    "right_bend": 16.0,
    "right_wrist": 0.0,
    "left_heel": 0.0,  # foot pitched about its ball
    "right_heel": 0.0,
    "hop": 0.0,  # both feet off the floor
}


@dataclass(frozen=True)
class Action:
    """One stretch of the choreography, frames ``first`` to ``last``, both included."""

    name: str
    first: int
    last: int


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


@dataclass
class _Script:
    """Keys and footfalls while they are being written."""

    keys: dict[str, list[tuple[float, float]]]
    feet: dict[str, list[tuple[float, float, np.ndarray, float]]]  # start, end, place on the floor, yaw
    place: np.ndarray
    yaw: float
    time: float

    def key(self, offset: float, **values: float) -> None:
        for channel, value in values.items():
            self.keys[channel].append((self.time + offset, value))

    def hold(self, offset: float, *channels: str) -> None:
        """Set channels to their stance value."""
        for channel in channels or tuple(STANCE):
            self.key(offset, **{channel: STANCE[channel]})

    def step(self, offset: float, duration: float, side: str) -> None:
        """Bring one foot beside the current place."""
        sign = 1.0 if side == "left" else -1.0
        aside = FOOT_WIDTH * sign * np.array([np.cos(self.yaw), np.sin(self.yaw)])
        start = self.time + offset
        self.feet[side].append((start, start + duration, self.place + aside, self.yaw + np.radians(9.0) * sign))


def _wave(script: _Script, draw: np.random.Generator, side: str) -> float:
    length = float(31 + draw.integers(-1, 3))
    lift = draw.normal(0, 2)
    up, down = 9.0, length - 9.0
    names = [f"{side}_{part}" for part in ("raise", "reach", "twist", "bend", "wrist")]
    other = "right" if side == "left" else "left"
    lean = -1.0 if side == "left" else 1.0
    script.hold(0, *names, "head_roll", "head_turn", "spine_roll", "shift", f"{other}_bend")
    for i, t in enumerate(np.linspace(up, down, 5)):
        swing_out = 1 if i % 2 else -1
        script.key(
            t,
            **{
                names[0]: 98 + lift + 3 * swing_out,
                names[1]: 12.0,
                names[2]: 92.0,
                names[3]: 72 + 22 * swing_out + draw.normal(0, 2),
                names[4]: -9.0 * swing_out,
            },
        )
    script.key(up + 3, head_roll=5 * lean, head_turn=-7 * lean, spine_roll=3 * lean, shift=0.018 * lean)
    script.key(down - 2, head_roll=6 * lean, head_turn=-5 * lean, spine_roll=3 * lean, shift=0.018 * lean)
    script.key(0.5 * length, **{f"{other}_bend": 22.0})
    script.hold(length, *names, "head_roll", "head_turn", "spine_roll", "shift", f"{other}_bend")
    return length


def _squat(script: _Script, draw: np.random.Generator) -> float:
    length = float(28 + draw.integers(-2, 3))
    depth = 0.33 + draw.normal(0, 0.015)
    channels = ["lower", "forward", "spine_pitch", "pelvis_pitch", "head_pitch"]
    arms = [f"{side}_{part}" for side in ("left", "right") for part in ("raise", "reach", "bend")]
    script.hold(0, *channels, *arms)
    middle = 0.5 * length + draw.normal(0, 0.4)
    for t in (middle - 2, middle + 2):
        script.key(t, lower=depth, forward=-0.075, spine_pitch=24, pelvis_pitch=20, head_pitch=-24)
        for side in ("left", "right"):
            script.key(t, **{f"{side}_raise": 12, f"{side}_reach": 128 + draw.normal(0, 2), f"{side}_bend": 12})
    script.hold(length, *channels, *arms)
    return length


def _jump(script: _Script, draw: np.random.Generator) -> float:
    length = 33.0
    high = 0.19 + draw.normal(0, 0.012)
    channels = ["lower", "forward", "spine_pitch", "pelvis_pitch", "head_pitch", "hop", "left_heel", "right_heel"]
    arms = [f"{side}_{part}" for side in ("left", "right") for part in ("raise", "reach", "bend")]
    script.hold(0, *channels, *arms)
    script.key(8, lower=0.22, forward=-0.03, spine_pitch=20, pelvis_pitch=12, head_pitch=-14)
    script.key(11, left_heel=0, right_heel=0, hop=0)
    script.key(13, lower=-0.06, forward=0.0, spine_pitch=-2, pelvis_pitch=0, head_pitch=-6, left_heel=40, right_heel=40)
    script.key(17.5, lower=-0.03 - high, hop=high, spine_pitch=4, left_heel=34, right_heel=34)
    script.key(22, lower=0.03, left_heel=14, right_heel=14, hop=0, spine_pitch=8)
    script.key(24, left_heel=0, right_heel=0, hop=0)
    script.key(25.5, lower=0.17, forward=-0.03, spine_pitch=17, pelvis_pitch=9, head_pitch=-12)
    for side in ("left", "right"):
        script.key(7, **{f"{side}_raise": 16, f"{side}_reach": -38, f"{side}_bend": 22})
        script.key(15, **{f"{side}_raise": 72 + draw.normal(0, 3), f"{side}_reach": 58, f"{side}_bend": 34})
        script.key(19, **{f"{side}_raise": 66, f"{side}_reach": 50, f"{side}_bend": 40})
        script.key(26, **{f"{side}_raise": 24, f"{side}_reach": 12, f"{side}_bend": 34})
    script.hold(length, *channels, *arms)
    return length


def _walk(script: _Script, draw: np.random.Generator, turn: float) -> float:
    """Four steps forward, turning by ``turn`` degrees on the way."""
    turn = np.radians(turn + draw.normal(0, 5))
    beat = 11.0 + draw.normal(0, 0.2)
    first = "left" if turn >= 0 else "right"
    other = "right" if first == "left" else "left"
    arms = [f"{side}_{part}" for side in ("left", "right") for part in ("reach", "bend")]
    channels = ["lower", "shift", "pelvis_turn", "spine_turn", "pelvis_roll", "left_heel", "right_heel", "spine_pitch"]
    script.hold(0, *channels, *arms)
    strides = (0.24, 0.27, 0.27, 0.0)
    for i, (stride, side) in enumerate(zip(strides, (first, other, first, other), strict=True)):
        script.yaw += turn / 4
        forward = np.array([np.sin(script.yaw), -np.cos(script.yaw)])
        script.place = script.place + stride * (1 + draw.normal(0, 0.03)) * forward
        start = 3 + beat * i
        script.step(start, beat * 0.92, side)
        sign = 1.0 if side == "left" else -1.0
        back = "right" if side == "left" else "left"
        last = i == 3
        middle = start + 0.5 * beat
        script.key(middle, shift=-0.045 * sign, pelvis_roll=-2.5 * sign, lower=0.02, spine_pitch=4)
        script.key(middle + 0.5 * beat, shift=0.0, pelvis_roll=0, lower=0.045 if not last else 0.02)
        swing_size = 0 if last else 1
        script.key(
            start + 0.9 * beat,
            pelvis_turn=-6.0 * sign * swing_size,
            spine_turn=10.0 * sign * swing_size,
            **{
                f"{side}_reach": 2 - 22.0 * swing_size,
                f"{back}_reach": 2 + 24.0 * swing_size,
                f"{side}_bend": 18,
                f"{back}_bend": 28,
            },
        )
        # The heel of the foot that steps leaves the floor first and is down again on landing.
        script.key(start - 5, **{f"{side}_heel": 0.0})
        script.key(start + 1.0, **{f"{side}_heel": 24.0 if i else 12.0})
        script.key(start + 0.45 * beat, **{f"{side}_heel": 10.0})
        script.key(start + 0.75 * beat, **{f"{side}_heel": 0.0})
    length = float(np.ceil(3 + 4 * beat))
    script.hold(length, *channels, *arms)
    return length


def _turn(script: _Script, draw: np.random.Generator, turn: float) -> float:
    """Turn on the spot by ``turn`` degrees in two steps."""
    turn = np.radians(turn + draw.normal(0, 4))
    first = "left" if turn >= 0 else "right"
    sign = 1.0 if turn >= 0 else -1.0
    channels = ["shift", "head_turn", "spine_turn", "lower"]
    script.hold(0, *channels)
    script.yaw += turn
    script.key(5, head_turn=18 * sign, spine_turn=9 * sign)
    script.step(3, 10, first)
    script.step(13, 10, "right" if first == "left" else "left")
    script.key(8, shift=-0.04 * sign, lower=0.03)
    script.key(18, shift=0.04 * sign, lower=0.03, head_turn=4 * sign)
    script.hold(26, *channels)
    return 26.0


def _sway(script: _Script, draw: np.random.Generator) -> float:
    """A little dance: hips from side to side, arms up, heels lifting."""
    beat = 9.0 + draw.normal(0, 0.15)
    channels = ["shift", "pelvis_roll", "spine_roll", "spine_turn", "head_roll", "lower", "left_heel", "right_heel"]
    arms = [f"{side}_{part}" for side in ("left", "right") for part in ("raise", "reach", "twist", "bend")]
    script.hold(0, *channels, *arms)
    for i in range(4):
        sign = 1.0 if i % 2 else -1.0
        size = 1 + draw.normal(0, 0.06)
        t = 6 + beat * i
        script.key(
            t,
            shift=0.075 * sign * size,
            pelvis_roll=-7 * sign * size,
            spine_roll=13 * sign * size,
            spine_turn=8 * sign,
            head_roll=-6 * sign,
            lower=0.045,
        )
        script.key(t + 0.5 * beat, lower=0.02)
        up, down = ("left", "right") if sign > 0 else ("right", "left")
        script.key(t, **{f"{down}_heel": 24.0 * size, f"{up}_heel": 0.0})
        for side, raised in ((up, 1.0), (down, 0.0)):
            script.key(
                t,
                **{
                    f"{side}_raise": 56 + 26 * raised * size,
                    f"{side}_reach": 28.0,
                    f"{side}_twist": 48 + 30 * raised,
                    f"{side}_bend": 68 - 18 * raised,
                },
            )
    length = float(np.ceil(6 + 3 * beat + 9))
    script.hold(length, *channels, *arms)
    return length


def choreograph(frames: int, seed: int) -> Motion:
    """The motion's first ``frames`` frames; a longer motion of the same seed starts with the same frames.

    Raises ValueError where ``frames`` < 1.
    """
    if frames < 1:
        raise ValueError(f"frames: expected at least 1, got {frames}")
    draw = np.random.Generator(np.random.PCG64(seed))
    script = _Script({name: [] for name in STANCE}, {"left": [], "right": []}, np.zeros(2), 0.0, 0.0)
    script.time = -20.0
    script.hold(0)
    script.step(0, 1, "left")
    script.step(0, 1, "right")
    script.time = 0.0
    actions: list[Action] = []

    def close(name: str, length: float) -> None:
        start = round(script.time)
        script.time = start + round(length)
        actions.append(Action(name, start, int(script.time) - 1))

    program = ("wave", "squat", "walk", "jump", "wave", "squat", "sway", "jump", "walk", "sway", "turn")
    spell, walks, turns = 0, 0, 0
    while script.time < frames + 40:
        close("stand", (14 if spell == 0 else 9) + float(draw.integers(0, 3)))
        name = program[spell % len(program)]
        if name == "wave":
            length = _wave(script, draw, "right")
        elif name == "squat":
            length = _squat(script, draw)
        elif name == "jump":
            length = _jump(script, draw)
        elif name == "sway":
            length = _sway(script, draw)
        elif name == "walk":
            length = _walk(script, draw, 80.0 if walks % 2 == 0 else -115.0)
            walks += 1
        else:
            length = _turn(script, draw, -55.0 if turns % 2 == 0 else 70.0)
            turns += 1
        close(name, length)
        spell += 1
    kept = tuple(Action(a.name, a.first, min(a.last, frames - 1)) for a in actions if a.first < frames)
    return _pose(script, frames, kept, np.random.Generator(np.random.PCG64([seed, 1])))


def _curves(script: _Script, times: np.ndarray) -> dict[str, np.ndarray]:
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


def _footpath(
    falls: list[tuple[float, float, np.ndarray, float]], times: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Place (frames, 2), yaw, height and whether it stands, of one foot's ball-to-be."""
    place = np.repeat(falls[0][2][None], len(times), 0)
    yaw = np.full(len(times), falls[0][3])
    height = np.zeros(len(times))
    still = np.ones(len(times), bool)
    for start, end, to, heading in falls[1:]:
        t = (times - start) / (end - start)
        s = _ease(t)
        place += s[:, None] * (to - _standing_before(falls, start)[0])
        yaw += s * (heading - _standing_before(falls, start)[1])
        inside = np.clip(t, 0.0, 1.0)
        distance = float(np.linalg.norm(to - _standing_before(falls, start)[0]))
        height += (0.035 + 0.08 * min(distance, 0.6)) * 64 * (inside * (1 - inside)) ** 3
        still &= (t <= 0) | (t >= 1)
    return place, yaw, height, still


def _standing_before(falls: list[tuple[float, float, np.ndarray, float]], start: float) -> tuple[np.ndarray, float]:
    """Where a foot stands just before ``start``."""
    earlier = [fall for fall in falls if fall[0] < start]
    return earlier[-1][2], earlier[-1][3]


def _pose(script: _Script, frames: int, actions: tuple[Action, ...], draw: np.random.Generator) -> Motion:
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
        place_leg(rotations, positions, side, ankle, pitched, pole)
    inside = slice(margin, margin + frames)
    planted = np.stack([feet["left"][3], feet["right"][3]], 1)
    return Motion(rotations[inside], positions[inside], yaw[inside], planted[inside], actions)


LEG = 0.994 * float(
    np.linalg.norm(REST[INDEX["left_knee"]] - REST[INDEX["left_hip"]])
    + np.linalg.norm(REST[INDEX["left_ankle"]] - REST[INDEX["left_knee"]])
)
REST_FOOT_YAW = float(np.arctan2(0.010, 0.134))


def _ball_of(side: str) -> np.ndarray:
    ball = REST[INDEX[f"{side}_toe"]].copy()
    ball[2] = 0.0
    return ball


def _soft_maximum(a: np.ndarray, b: np.ndarray, blend: float) -> np.ndarray:
    h = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.maximum(a, b) + h * h * h * blend / 6


def _arm(local: dict[str, np.ndarray], c: dict[str, np.ndarray], side: str, drift: object, breath: np.ndarray) -> None:
    """Clavicle, shoulder, elbow and wrist from the arm's channels."""
    sign = 1.0 if side == "left" else -1.0
    rad = np.radians
    sway = drift  # one slow curve a channel
    raised = rad(c[f"{side}_raise"] + sway(0.9, 101) + 0.3 * breath)  # type: ignore[operator]
    reach = rad(c[f"{side}_reach"] + sway(1.0, 123))  # type: ignore[operator]
    twist = rad(c[f"{side}_twist"])
    bend = rad(c[f"{side}_bend"] + sway(1.2, 89))  # type: ignore[operator]
    wrist = rad(c[f"{side}_wrist"] + sway(1.2, 71))  # type: ignore[operator]
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
