"""One tracked pair in, two transitions out, or a refusal (P section 6)."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import Refusal
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.align import align_windows
from unstructured_mg.synthesis.blend import BLENDS, Blend, blend_postures, windows_of
from unstructured_mg.synthesis.captured import colour_change, surface_change, surface_distance
from unstructured_mg.synthesis.feet import plant_feet
from unstructured_mg.synthesis.frames import Frames, KeptFrames
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.posture import Posture, Template
from unstructured_mg.synthesis.quality import objections, quality_card, with_texture
from unstructured_mg.synthesis.texture import TextureBlend, build_texture_surface, synthesize_textures
from unstructured_mg.synthesis.transition import Transition
from unstructured_mg.synthesis.weights import WEIGHTS
from unstructured_mg.tracking.pair import TrackedPair

NO_TEXTURE = TextureBlend(np.zeros((0, 2)), np.zeros((0, 3), np.int32), (), "", None, None, {})


def synthesize(
    capture: Capture, pair: TrackedPair, options: SynthesisOptions
) -> tuple[Transition, Transition] | Refusal:
    """The transitions source -> target and target -> source of a tracked pair, or why there are none.

    The windows are aligned on the floor plane, every step's geometry is blended and placed, feet that stand are locked,
    textures are moved along the flow, and the quality card decides. Both directions are kept or refused together: a
    pair is one choice. Geometry is judged before any texture is made. Besides the template frame the two outermost
    frames at each end of each window are read, to measure seams against what the capture does there.
    """
    if pair.k < 2:
        raise ValueError(f"pair.k: expected at least 2, got {pair.k}")
    frames = KeptFrames(capture)
    alignment = align_windows(pair)
    blend = BLENDS[options.blend](Template.of_pair(pair))
    own_surface = surface_change(frames, pair)
    ways = []
    for reverse in (False, True):
        way = _blend_way(frames, pair, alignment, blend, options, reverse)
        card = _geometry_card(way, pair, options, own_surface)
        refusal = _refusal(card, options, reverse)
        if refusal is not None:
            return refusal
        ways.append((way, card))
    if options.texture == "none":
        first, second = (_transition(way, pair, NO_TEXTURE, card) for way, card in ways)
        return first, second
    texturing = replace(options.texturing, method=options.texture)
    own_colour = colour_change(frames, pair, texturing)
    prepared = build_texture_surface(frames, pair, texturing) if own_colour is not None else None
    transitions = []
    for way, card in ways:
        texture = synthesize_textures(frames, pair, way.start, way.end, 2 * pair.k - 1, texturing, prepared)
        card = with_texture(card, own_colour, texture.measures)
        refusal = _refusal(card, options, way.reverse)
        if refusal is not None:
            return refusal
        transitions.append(_transition(way, pair, texture, card))
    return transitions[0], transitions[1]


@dataclass(frozen=True)
class _Way:
    """One direction of a pair: the window it leaves, the one it meets, and its steps, all in the first one's place.

    ``start`` and ``end`` are positions in the pair's frames; ``alignment`` takes the end's place to the start's.
    """

    reverse: bool
    start: int
    end: int
    alignment: PlanarRigid
    first: list[Posture]
    second: list[Posture]
    steps: list[Posture]
    surface_jumps: tuple[float, float]
    windows: tuple[np.ndarray, np.ndarray]


def _blend_way(
    frames: Frames, pair: TrackedPair, alignment: PlanarRigid, blend: Blend, options: SynthesisOptions, reverse: bool
) -> _Way:
    leaving, meeting = pair.steps[::-1] if reverse else pair.steps
    start, end = int(leaving[0]), int(meeting[-1])
    to_start = alignment.inverse() if reverse else alignment
    first, second = windows_of(pair, alignment, reverse)
    steps = blend_postures(pair, alignment, options, reverse, blend)
    if options.plant_feet:
        steps = plant_feet(Template.of_pair(pair), steps, first, second, WEIGHTS[options.weights](pair.k))
    before, after = frames.read(int(pair.frames[start])), frames.read(int(pair.frames[end]))
    jumps = (
        surface_distance(before.vertices, before.faces, steps[1].surface, pair.faces),
        surface_distance(to_start.apply(after.vertices), after.faces, steps[-2].surface, pair.faces),
    )
    whole = [pair.vertices[window] for window in pair.windows]
    if reverse:
        whole.reverse()
    windows = whole[0], to_start.apply(whole[1])
    return _Way(reverse, start, end, to_start, first, second, steps, jumps, windows)


def _geometry_card(way: _Way, pair: TrackedPair, options: SynthesisOptions, own_surface: float) -> dict[str, Any]:
    weights = WEIGHTS[options.weights](pair.k)
    return quality_card(
        way.steps, way.first, way.second, way.windows, weights, pair.faces, pair.tets, way.surface_jumps, own_surface
    )


def _refusal(card: dict[str, Any], options: SynthesisOptions, reverse: bool) -> Refusal | None:
    found = objections(card, options)
    if not found:
        return None
    return Refusal("synthesis", f"on the way {'back' if reverse else 'over'} {'; '.join(found)}", _numbers(card))


def _transition(way: _Way, pair: TrackedPair, texture: TextureBlend, card: dict[str, Any]) -> Transition:
    return Transition(
        pair.target if way.reverse else pair.source,
        pair.source if way.reverse else pair.target,
        pair.k,
        np.stack([posture.surface for posture in way.steps[1:-1]]),
        pair.faces,
        texture.uv,
        texture.face_uv,
        texture.textures,
        texture.texture_suffix,
        texture.colors,
        way.alignment,
        card,
        texture.flow,
        None if pair.warp is None else (int(pair.frames[way.start]), int(pair.frames[way.end])),
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
