"""One tracked pair in, two transitions out, or a refusal (P section 6)."""

from typing import Any

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import Refusal
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.align import align_windows
from unstructured_mg.synthesis.blend import BLENDS, Blend, blend_postures, windows_of
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.posture import Template
from unstructured_mg.synthesis.quality import captured_change, objections, quality_card, surface_distance
from unstructured_mg.synthesis.transition import Transition
from unstructured_mg.synthesis.weights import WEIGHTS
from unstructured_mg.tracking.pair import TrackedPair


def synthesize(
    capture: Capture, pair: TrackedPair, options: SynthesisOptions
) -> tuple[Transition, Transition] | Refusal:
    """The transitions source -> target and target -> source of a tracked pair, or why there are none.

    The windows are aligned on the floor plane, every step's geometry is blended and placed, textures are moved along
    the flow, and the quality card decides. Both directions are kept or refused together: a pair is one choice.
    Reads eight frames of the capture for the seams besides those whose textures are needed.
    """
    if pair.k < 2:
        raise ValueError(f"pair.k: expected at least 2, got {pair.k}")
    alignment = align_windows(pair)
    blend = BLENDS[options.blend](Template.of_pair(pair))
    captured = _window_ends(capture, pair)
    half = 2 * pair.k + 1
    change = max(captured_change(captured, pair.frames[:half]), captured_change(captured, pair.frames[half:]))
    transitions = []
    for reverse in (False, True):
        transition = _direction(pair, alignment, blend, captured, change, options, reverse)
        found = objections(transition.card, options)
        if found:
            way = "back" if reverse else "over"
            return Refusal("synthesis", f"On the way {way}, {'; '.join(found)}.", _numbers(transition.card))
        transitions.append(transition)
    return transitions[0], transitions[1]


def _window_ends(capture: Capture, pair: TrackedPair) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """The captured vertices and faces of the two outermost frames at each end of each window."""
    half = 2 * pair.k + 1
    positions = [start + offset for start in (0, half) for offset in (0, 1, half - 2, half - 1)]
    meshes = {int(pair.frames[i]): capture.read(int(pair.frames[i])) for i in positions}
    return {frame: (mesh.vertices, mesh.faces) for frame, mesh in meshes.items()}


def _direction(
    pair: TrackedPair,
    alignment: PlanarRigid,
    blend: Blend,
    captured: dict[int, tuple[np.ndarray, np.ndarray]],
    change: float,
    options: SynthesisOptions,
    reverse: bool,
) -> Transition:
    half = 2 * pair.k + 1
    start, end = (half, half - 1) if reverse else (0, 2 * half - 1)
    to_start = alignment.inverse() if reverse else alignment
    first, second = windows_of(pair, alignment, reverse)
    steps = blend_postures(pair, alignment, options, reverse, blend)
    start_vertices, start_faces = captured[int(pair.frames[start])]
    end_vertices, end_faces = captured[int(pair.frames[end])]
    jumps = (
        surface_distance(start_vertices, start_faces, steps[1].surface, pair.faces),
        surface_distance(to_start.apply(end_vertices), end_faces, steps[-2].surface, pair.faces),
    )
    weights = WEIGHTS[options.weights](pair.k)
    card = quality_card(steps, first, second, weights, pair.faces, pair.tets, jumps, change, {})
    return Transition(
        pair.target if reverse else pair.source,
        pair.source if reverse else pair.target,
        pair.k,
        np.stack([posture.surface for posture in steps[1:-1]]),
        pair.faces,
        np.zeros((0, 2)),
        np.zeros((0, 3), np.int32),
        (),
        "",
        None,
        to_start,
        card,
    )


def _numbers(card: dict[str, Any], prefix: str = "") -> dict[str, float]:
    """The card's numbers under flat names, for a refusal's measures."""
    flat: dict[str, float] = {}
    for key, value in card.items():
        if isinstance(value, dict):
            flat.update(_numbers(value, f"{prefix}{key}_"))
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            flat[prefix + key] = float(value)
    return flat
