"""What a blend is given: the template that all frames share, and one frame's fit of it."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.tracking.pair import TrackedPair


@dataclass(frozen=True)
class Template:
    """The rest shape to which blends refer, with the cage that carries the surface.

    Attributes
    ----------
    surface : (n, 3) float64, metres
    faces : (m, 3) int32
    cage : (c, 3) float64, metres
    tets : (q, 4) int32, positively oriented at ``cage``
    tet_of_vertex : (n,) int32 the cage cell that carries each surface vertex
    weights : (n, 4) float64 barycentric weights in that cell
    frames : (f, n, 3) float64, metres: the surface in all frames that are known of it
    """

    surface: np.ndarray
    faces: np.ndarray
    cage: np.ndarray
    tets: np.ndarray
    tet_of_vertex: np.ndarray
    weights: np.ndarray
    frames: np.ndarray

    @classmethod
    def of_pair(cls, pair: TrackedPair) -> "Template":
        return cls(
            pair.vertices[pair.template],
            pair.faces,
            pair.cage_vertices[pair.template],
            pair.tets,
            pair.tet_of_vertex,
            pair.weights,
            pair.vertices,
        )


@dataclass(frozen=True)
class Posture:
    """The template's ``surface`` (n, 3) and ``cage`` (c, 3) in one frame, float64, metres.

    ``cage`` is None where a blend made the frame without it.
    """

    surface: np.ndarray
    cage: np.ndarray | None
