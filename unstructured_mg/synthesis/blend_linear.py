"""Linear blend of vertex positions, for comparison: it shrinks what turns."""

import numpy as np

from unstructured_mg.synthesis.posture import Posture, Template


class LinearBlend:
    """(1-l) source + l target, vertex by vertex, surface and cage."""

    def __init__(self, template: Template):
        self.template = template

    def __call__(self, source: Posture, target: Posture, weight: float) -> Posture:
        cage = None
        if source.cage is not None and target.cage is not None:
            cage = between(source.cage, target.cage, weight)
        return Posture(between(source.surface, target.surface, weight), cage)


def between(source: np.ndarray, target: np.ndarray, weight: float) -> np.ndarray:
    """(1-l) source + l target: every blend starts from it and is posed on it."""
    return (1 - weight) * source + weight * target
