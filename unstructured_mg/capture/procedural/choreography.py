"""What the procedural figure does: actions written as keys of a few control channels and as footfalls.

Sizes and timings are drawn from a seeded generator: repeats are alike and not equal. Between any two actions the
figure stands.
"""

from dataclasses import dataclass

import numpy as np

FOOT_WIDTH = 0.125  # metres from the middle to each foot in the stance

TOES_OUT = 9.0  # degrees each foot is turned outwards

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
class Footfall:
    """A foot leaves the floor at frame ``start`` and stands from ``end`` on at ``place`` (2,), turned by ``yaw``."""

    start: float
    end: float
    place: np.ndarray
    yaw: float


@dataclass
class Script:
    """Keys (frame, value) of every channel and falls of both feet; place, yaw and time are where it has got to."""

    keys: dict[str, list[tuple[float, float]]]
    feet: dict[str, list[Footfall]]
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
        heading = self.yaw + np.radians(TOES_OUT) * sign
        self.feet[side].append(Footfall(start, start + duration, self.place + aside, heading))


def _wave(script: Script, draw: np.random.Generator, side: str) -> float:
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


def _squat(script: Script, draw: np.random.Generator) -> float:
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


def _jump(script: Script, draw: np.random.Generator) -> float:
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


def _walk(script: Script, draw: np.random.Generator, turn: float) -> float:
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
        # The last step only brings the second foot beside the first.
        script.yaw += turn / 3 if i < 3 else 0.0
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


def _turn(script: Script, draw: np.random.Generator, turn: float) -> float:
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


def _drift(script: Script, draw: np.random.Generator) -> float:
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


def compose(frames: int, seed: int) -> tuple[Script, tuple[Action, ...]]:
    """The script of at least ``frames`` frames and its labelled stretches up to there."""
    draw = np.random.Generator(np.random.PCG64(seed))
    script = Script({name: [] for name in STANCE}, {"left": [], "right": []}, np.zeros(2), 0.0, 0.0)
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
        # Every channel is at its stance at both ends of a stand, so no later action bends an earlier one.
        script.hold(0)
        close("stand", (14 if spell == 0 else 9) + float(draw.integers(0, 3)))
        script.hold(0)
        name = program[spell % len(program)]
        if name == "wave":
            length = _wave(script, draw, "right")
        elif name == "squat":
            length = _squat(script, draw)
        elif name == "jump":
            length = _jump(script, draw)
        elif name == "sway":
            length = _drift(script, draw)
        elif name == "walk":
            length = _walk(script, draw, 80.0 if walks % 2 == 0 else -115.0)
            walks += 1
        else:
            length = _turn(script, draw, -55.0 if turns % 2 == 0 else 70.0)
            turns += 1
        close(name, length)
        spell += 1
    kept = tuple(Action(a.name, a.first, min(a.last, frames - 1)) for a in actions if a.first < frames)
    return script, kept
