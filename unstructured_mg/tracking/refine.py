"""Registered surface to target, the last millimetres: surface ARAP, which also evens out the cage's creases."""

import numpy as np

from unstructured_mg.geometry.laplacian import stiffness_matrix
from unstructured_mg.geometry.normals import vertex_normals
from unstructured_mg.geometry.rotations import fit_rotations
from unstructured_mg.geometry.solver import SymmetricSolver
from unstructured_mg.geometry.triangles import TriangleElements
from unstructured_mg.tracking.surface import CleanSurface, vertex_areas
from unstructured_mg.tracking.target import Target


class Refiner:
    """Vertices v minimising sum a_i (n_i . (q_i - v_i))^2 + length^2 sum_f |f| min_R |F_f - R|^2.

    q_i is the target point nearest to v_i and n_i the target's normal there; no pull where normals disagree or it is
    too far. a are areas, F_f the map of triangle f from the template. A triangle may turn freely and so bending costs
    nothing, but the surface keeps its metric: point-to-plane data say nothing about sliding, and skin and cloth hardly
    stretch. Local and global steps, the matrix factored once for a template. ``length`` and ``reach`` are in metres.
    """

    def __init__(self, surface: CleanSurface, length: float, reach: float):
        self.faces = surface.faces[surface.geometric]
        areas = vertex_areas(surface.vertices, self.faces)
        # Vertices without area stay where the cage carries them.
        self._areas = np.maximum(areas, 1e-3 * areas.mean())
        self._reach = reach
        self._stiffness = length**2
        self._elements = TriangleElements(surface.vertices, self.faces)
        system = self._stiffness * stiffness_matrix(surface.vertices, self.faces)
        system.setdiag(system.diagonal() + self._areas)
        self._solver = SymmetricSolver(system)

    def refine(self, vertices: np.ndarray, target: Target, iterations: int) -> np.ndarray:
        """Vertices (n, 3) after so many rounds of closest points, rotations and solve, from the given ones."""
        for _ in range(iterations):
            normals = vertex_normals(vertices, self.faces)
            nearest, goal_normals = target.closest(vertices)
            away = nearest - vertices
            agreeing = np.einsum("nx,nx->n", normals, goal_normals) > 0.5
            agreeing &= np.einsum("nx,nx->n", away, away) < self._reach**2
            along = np.einsum("nx,nx->n", goal_normals, away) * agreeing
            goals = vertices + along[:, None] * goal_normals
            rotations = fit_rotations(self._elements.deformation(vertices))
            pull = self._areas[:, None] * goals + self._stiffness * self._elements.divergence(rotations)
            vertices = self._solver.solve(pull)
        return vertices
