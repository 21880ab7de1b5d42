"""glTF animations: what every node does at a moment."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.gltf_file import REMEDY, Gltf, is_index, read_accessor

_VISIBLE = "/extensions/KHR_node_visibility/visible"
_TYPES = {
    "translation": ("VEC3",),
    "rotation": ("VEC4",),
    "scale": ("VEC3",),
    "weights": ("SCALAR",),
    "visible": ("SCALAR",),
}
#: More frames than this in one file are a lie about its duration.
MOST_FRAMES = 1 << 20


@dataclass(frozen=True, eq=False)
class Channel:
    """One animated property of a node. ``times (k,)`` ascending seconds, ``values (k, w)``; STEP where ``steps``."""

    node: int
    path: str
    times: np.ndarray
    values: np.ndarray
    steps: bool


def read_channels(gltf: Gltf) -> tuple[Channel, ...]:
    """The channels of the file's first animation that move, hide or bend a node.

    Raises FrameError where times do not ascend, or values do not fit them.
    """
    animations = gltf.data.get("animations")
    if not isinstance(animations, list) or not animations:
        return ()
    animation = gltf.item("animations", 0)
    samplers = animation.get("samplers", [])
    channels = []
    for number, channel in enumerate(animation.get("channels", [])):
        where = f"animations[0].channels[{number}]"
        target = channel.get("target") if isinstance(channel, dict) else None
        node, path = _target(target)
        if node is None:
            continue
        index = channel.get("sampler")
        if not is_index(index) or index >= len(samplers) or not isinstance(samplers[index], dict):
            raise FrameError(gltf.path, f"{where} names sampler {index}, which is not there", REMEDY)
        sampler = samplers[index]
        interpolation = sampler.get("interpolation", "LINEAR")
        with np.errstate(invalid="ignore"):  # a time that is not a number is refused below, a place with the frame
            times = read_accessor(gltf, sampler.get("input"), ("SCALAR",)).astype(np.float64)
            values = read_accessor(gltf, sampler.get("output"), _TYPES[path]).astype(np.float64)
        values = values.reshape(len(values), -1)
        if path == "weights":
            if len(values) % len(times):
                raise FrameError(gltf.path, f"{where}: {len(values)} weights for {len(times)} times", REMEDY)
            values = values.reshape(len(times), -1)
        if interpolation == "CUBICSPLINE":
            raise FrameError(gltf.path, f"{where} is a cubic spline", "export the animation sampled, frame by frame")
        if len(values) != len(times) or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
            raise FrameError(gltf.path, f"{where}: expected a value for each of {len(times)} ascending times", REMEDY)
        channels.append(Channel(node, path, times, values, interpolation == "STEP" or path == "visible"))
    return tuple(channels)


def frame_times(gltf: Gltf, channels: tuple[Channel, ...]) -> np.ndarray:
    """The moments that the file's key frames stand at, filled up to an even rate, in seconds.

    Where the last of them only ends the frame before it (nothing changes there), it is left out.
    """
    times = np.unique(np.concatenate([channel.times for channel in channels])) if channels else np.zeros(0)
    if len(times) < 2:
        return times
    gaps = np.diff(times)
    step = float(gaps.min())
    step = float(np.median(gaps[gaps < 1.5 * step]))
    count = round((times[-1] - times[0]) / step) + 1
    if count > MOST_FRAMES:
        raise FrameError(gltf.path, f"its animation has {count} frames", f"at most {MOST_FRAMES} can be read")
    last = [(c.times[-1] < times[-1]) or (len(c.values) > 1 and (c.values[-1] == c.values[-2]).all()) for c in channels]
    if all(c.steps for c in channels) and all(last):
        count -= 1
    return times[0] + step * np.arange(count)


def state_at(channels: tuple[Channel, ...], time: float, tolerance: float) -> dict[tuple[int, str], np.ndarray]:
    """The value of every animated property, by node and path, at ``time``; steps count from ``tolerance`` before."""
    state = {}
    for channel in channels:
        after = int(np.searchsorted(channel.times, time + tolerance, side="right"))
        before = max(after - 1, 0)
        value = channel.values[before]
        if not channel.steps and 0 < after < len(channel.times):
            span = channel.times[after] - channel.times[before]
            share = min(max((time - channel.times[before]) / span, 0.0), 1.0)
            value = _between(channel, before, share)
        state[channel.node, channel.path] = value
    return state


def _between(channel: Channel, before: int, share: float) -> np.ndarray:
    a, b = channel.values[before], channel.values[before + 1]
    if channel.path != "rotation":
        return (1 - share) * a + share * b
    if a @ b < 0:
        b = -b
    angle = np.arccos(min(float(a @ b), 1.0))
    if angle < 1e-6:
        mixed = (1 - share) * a + share * b
    else:
        mixed = (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)
    return mixed / np.linalg.norm(mixed)


def _target(target: Any) -> tuple[int | None, str]:
    if not isinstance(target, dict):
        return None, ""
    path, node = target.get("path"), target.get("node")
    if path == "pointer":
        pointer = target.get("extensions", {}).get("KHR_animation_pointer", {}).get("pointer", "")
        number = str(pointer).removeprefix("/nodes/").removesuffix(_VISIBLE)
        if str(pointer).endswith(_VISIBLE) and number.isdecimal():
            return int(number), "visible"
        return None, ""
    if isinstance(path, str) and path in _TYPES and is_index(node):
        return node, path
    return None, ""
