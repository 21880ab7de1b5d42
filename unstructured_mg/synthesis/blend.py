"""The geometry of a transition: one blend a step, whatever the method (P section 6.4 and 6.5)."""

from collections.abc import Callable

import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.blend_latent import LatentBlend
from unstructured_mg.synthesis.blend_linear import LinearBlend
from unstructured_mg.synthesis.blend_poisson import PoissonBlend
from unstructured_mg.synthesis.blend_surface_arap import SurfaceArapBlend
from unstructured_mg.synthesis.blend_volumetric_arap import VolumetricArapBlend
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.posture import Posture, Template
from unstructured_mg.synthesis.weights import WEIGHTS
from unstructured_mg.tracking.pair import TrackedPair

# A blend is made once for a template and called for each step: source and target posture in one place, weight from
# 0 (source) to 1 (target). It meets both ends, and swapping source and target with 1 - weight changes nothing.
Blend = Callable[[Posture, Posture, float], Posture]

BLENDS: dict[str, Callable[[Template], Blend]] = {
    "volumetric_arap": VolumetricArapBlend,
    "surface_arap": SurfaceArapBlend,
    "poisson": PoissonBlend,
    "linear": LinearBlend,
    "latent": LatentBlend,
}


def windows_of(pair: TrackedPair, alignment: PlanarRigid, reverse: bool) -> tuple[list[Posture], list[Posture]]:
    """What is blended at each step: postures of the window that a transition leaves, then of the one it meets, both in
    the place of the one it leaves.

    ``alignment`` takes the target's place to the source's; ``reverse`` asks for the transition from target to source.
    """
    shapes = list(zip(pair.vertices, pair.cage_vertices, strict=True))
    first, second = ([shapes[position] for position in steps] for steps in pair.steps)
    if reverse:
        first, second, alignment = second, first, alignment.inverse()
    return (
        [Posture(surface, cage) for surface, cage in first],
        [Posture(alignment.apply(surface), alignment.apply(cage)) for surface, cage in second],
    )


def blend_postures(
    pair: TrackedPair, alignment: PlanarRigid, options: SynthesisOptions, reverse: bool, blend: Blend | None = None
) -> list[Posture]:
    """The ``2k+1`` postures of a transition, both ends included, in the place of the window it leaves.

    ``blend`` may be handed in where both directions share it (it is factored once); without it, it is made here.
    """
    blend = blend or BLENDS[options.blend](Template.of_pair(pair))
    first, second = windows_of(pair, alignment, reverse)
    weights = WEIGHTS[options.weights](pair.k)
    inner = [blend(first[i], second[i], float(weights[i])) for i in range(1, 2 * pair.k)]
    return [first[0], *inner, second[-1]]


def blend_windows(
    pair: TrackedPair, alignment: PlanarRigid, options: SynthesisOptions, reverse: bool = False
) -> np.ndarray:
    """Surface vertices ``(2k+1, n, 3) float64`` of a transition, both ends included, as ``blend_postures``."""
    return np.stack([posture.surface for posture in blend_postures(pair, alignment, options, reverse)])
