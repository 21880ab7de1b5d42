"""As-rigid-as-possible blend of the surface alone (P Fig. 8), for comparison: thin limbs lose volume."""

import numpy as np
import scipy.sparse as sp

from unstructured_mg.geometry.laplacian import stiffness_matrix
from unstructured_mg.geometry.rotations import fit_rotations
from unstructured_mg.geometry.triangles import TriangleElements
from unstructured_mg.synthesis.align import vertex_areas
from unstructured_mg.synthesis.blend_linear import between
from unstructured_mg.synthesis.pose import pose_parts
from unstructured_mg.synthesis.posture import Posture, Template
from unstructured_mg.synthesis.two_sided import PinnedSolver


class SurfaceArapBlend:
    """Two-sided as-rigid-as-possible energy on the surface, spokes and rims (Chao et al. 2010).

    Minimises (1-l) E(v, source) + l E(v, target) with E(v, r) = sum_i sum_{f at i} area_f |F_f(v) - R_i F_f(r)|_F^2 /
    3, R_i the best rotation of the one-ring of vertex i and F_f the tangential deformation gradients relative to the
    template, by local/global steps from the linear blend. One matrix, factored once. (Spokes alone lose the ends
    where cotangents are negative, as they are on captured meshes.)
    """

    def __init__(self, template: Template, iterations: int = 20):
        self._elements = TriangleElements(template.surface, template.faces)
        corners = template.faces.ravel()
        owner = np.repeat(np.arange(len(template.faces)), 3)
        ones = np.ones(len(corners))
        self._ring = sp.csr_matrix((ones, (corners, owner)), (len(template.surface), len(template.faces)))
        self._mean = sp.csr_matrix((ones / 3, (owner, corners)), (len(template.faces), len(template.surface)))
        self._masses = vertex_areas(template.surface, template.faces)
        self._solver = PinnedSolver(stiffness_matrix(template.surface, template.faces))
        self._iterations = iterations

    def __call__(self, source: Posture, target: Posture, weight: float) -> Posture:
        middle = between(source.surface, target.surface, weight)
        source_shape = self._elements.tangential(source.surface)
        target_shape = self._elements.tangential(target.surface)
        new = middle
        for _ in range(self._iterations):
            shape = self._elements.tangential(new)
            wanted = (1 - weight) * self._turned(shape, source_shape) + weight * self._turned(shape, target_shape)
            new = self._solver.solve(self._elements.divergence(wanted), middle)
        return Posture(pose_parts(new, middle, self._masses, self._solver.parts), None)

    def _turned(self, shape: np.ndarray, rest_shape: np.ndarray) -> np.ndarray:
        """Each triangle's rest shape (m, 3, 3), turned by the mean of its corners' best rotations."""
        products = self._elements.areas[:, None, None] * (shape @ rest_shape.transpose(0, 2, 1))
        rotations = fit_rotations((self._ring @ products.reshape(-1, 9)).reshape(-1, 3, 3))
        return (self._mean @ rotations.reshape(-1, 9)).reshape(-1, 3, 3) @ rest_shape
