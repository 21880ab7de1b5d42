"""Poisson blend of deformation gradients (B section 5)."""

from unstructured_mg.geometry.laplacian import stiffness_matrix
from unstructured_mg.geometry.triangles import TriangleElements
from unstructured_mg.synthesis.align import vertex_areas
from unstructured_mg.synthesis.blend_linear import between
from unstructured_mg.synthesis.pose import pose_parts
from unstructured_mg.synthesis.posture import Posture, Template
from unstructured_mg.synthesis.two_sided import PinnedSolver, between_stretches


class PoissonBlend:
    """Rotations and stretches of all triangles interpolated on their own, then stitched by one linear solve.

    Minimises sum_m area_m |F_m(v) - T_m|_F^2 (B eq. 13), F the triangles' deformation gradients relative to the
    template and T_m their blend (B eq. 9 to 12). Both frames are taken relative to the template rather than one to
    the other and back: one factor serves all frames, no second solve is needed for symmetry, and the blend meets
    both ends. The parts are placed as in P section 6.5.
    """

    def __init__(self, template: Template):
        self._elements = TriangleElements(template.surface, template.faces)
        self._masses = vertex_areas(template.surface, template.faces)
        self._solver = PinnedSolver(stiffness_matrix(template.surface, template.faces))

    def __call__(self, source: Posture, target: Posture, weight: float) -> Posture:
        middle = between(source.surface, target.surface, weight)
        targets = between_stretches(
            self._elements.deformation(source.surface), self._elements.deformation(target.surface), weight
        )
        new = self._solver.solve(self._elements.divergence(targets), middle)
        return Posture(pose_parts(new, middle, self._masses, self._solver.parts), None)
