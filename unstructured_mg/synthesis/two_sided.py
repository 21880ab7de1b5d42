"""What blends share: the start of each element between two shapes, and the solve that stitches elements."""

import numpy as np
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from unstructured_mg.geometry.rotations import fit_rotations
from unstructured_mg.geometry.solver import SymmetricSolver
from unstructured_mg.synthesis.pose import parts_of


def between_stretches(source: np.ndarray, target: np.ndarray, weight: float) -> np.ndarray:
    """Deformations ``(q, 3, 3)`` on the way from ``source`` to ``target``, all relative to one rest shape.

    With F = R S the polar decomposition: R_s exp(l log(R_s^T R_t)) ((1-l) S_s + l S_t) (B eq. 11, taken from the
    template, so that source and target are treated alike and both ends are met).
    """
    source_turn, target_turn = fit_rotations(source), fit_rotations(target)
    stretch = (1 - weight) * source_turn.transpose(0, 2, 1) @ source + weight * target_turn.transpose(0, 2, 1) @ target
    step = Rotation.from_matrix(source_turn.transpose(0, 2, 1) @ target_turn).as_rotvec()
    return source_turn @ Rotation.from_rotvec(weight * step).as_matrix() @ stretch


class PinnedSolver:
    """Solves K x = b where K only sees differences, by holding one vertex a part at a given place; factored once.

    The pin costs nothing: shifting a part does not change K x. The place matters little, since parts are posed later.
    """

    def __init__(self, stiffness: sp.spmatrix):
        self.parts = parts_of(stiffness)
        _, self._pins = np.unique(self.parts, return_index=True)
        diagonal = np.zeros(stiffness.shape[0])
        self._strength = max(float(stiffness.diagonal().mean()), np.finfo(float).tiny)
        diagonal[self._pins] = self._strength
        self._solver = SymmetricSolver(stiffness + sp.diags(diagonal))

    def solve(self, right: np.ndarray, places: np.ndarray) -> np.ndarray:
        """x (n, 3) for ``right`` (n, 3); the pinned vertices lie at ``places`` (n, 3)."""
        right = right.copy()
        right[self._pins] += self._strength * places[self._pins]
        return self._solver.solve(right)
