"""The last millimetre: a smooth vertex-level displacement of the registered surface onto the target."""

import numpy as np

from unstructured_mg.geometry.laplacian import stiffness_matrix
from unstructured_mg.geometry.solver import SymmetricSolver
from unstructured_mg.tracking.surface import CleanSurface, vertex_areas, vertex_normals
from unstructured_mg.tracking.target import Target


class Refiner:
    """Displacements d minimising sum a_i |d_i - d*_i|^2 + length^2 sum |grad d|^2, factored once for a template.

    d* is the way to the tangent plane at the nearest target point, zero where normals disagree or it is too far; a are
    areas. Around the cage's nearly rigid result, smoothness of d is rigidity: d has no reason to slide.
    ``length`` and ``reach`` are in metres.
    """

    def __init__(self, surface: CleanSurface, length: float, reach: float):
        self.faces = surface.faces[surface.geometric]
        areas = vertex_areas(surface.vertices, self.faces)
        # Vertices without area stay where the cage carries them.
        self._areas = np.maximum(areas, 1e-3 * areas.mean())
        self._reach = reach
        system = length**2 * stiffness_matrix(surface.vertices, self.faces)
        system.setdiag(system.diagonal() + self._areas)
        self._solver = SymmetricSolver(system)

    def refine(self, vertices: np.ndarray, target: Target, iterations: int) -> np.ndarray:
        """Vertices (n, 3) after so many rounds of closest points and solve, displaced from the given ones."""
        displaced = vertices
        for _ in range(iterations):
            normals = vertex_normals(displaced, self.faces)
            nearest, goal_normals = target.closest(displaced)
            away = nearest - displaced
            agreeing = np.einsum("nx,nx->n", normals, goal_normals) > 0.5
            agreeing &= np.einsum("nx,nx->n", away, away) < self._reach**2
            along = np.einsum("nx,nx->n", goal_normals, away) * agreeing
            wanted = displaced - vertices + along[:, None] * goal_normals
            displaced = vertices + self._solver.solve(self._areas[:, None] * wanted)
        return displaced
