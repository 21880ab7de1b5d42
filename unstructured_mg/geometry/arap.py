"""Volumetric as-rigid-as-possible deformation with one rest shape (P A.2; Chao et al. 2010)."""

import numpy as np
import scipy.sparse as sp

from unstructured_mg.geometry.elements import element_forces
from unstructured_mg.geometry.rotations import fit_rotations
from unstructured_mg.geometry.solver import SymmetricSolver
from unstructured_mg.geometry.tets import deformation_gradients, tet_gradients, tet_volumes


def arap_stiffness(rest: np.ndarray, tets: np.ndarray) -> sp.csc_matrix:
    """K ``(c, c)`` with ``sum_abc v^T K v = sum |tet| |L|_F^2``: the quadratic part of the ARAP energy."""
    gradients, volumes = tet_gradients(rest, tets), np.abs(tet_volumes(rest, tets))
    blocks = np.einsum("q,qia,qja->qij", volumes, gradients, gradients)
    rows, columns = np.repeat(tets, 4, axis=1).ravel(), np.tile(tets, (1, 4)).ravel()
    return sp.coo_matrix((blocks.ravel(), (rows, columns)), shape=(len(rest), len(rest))).tocsc()


def arap_forces(
    vertex_count: int, tets: np.ndarray, gradients: np.ndarray, volumes: np.ndarray, rotations: np.ndarray
) -> np.ndarray:
    """The right-hand side ``(c, 3)`` of the global step: for every vertex, sum |tet| R grad(hat)."""
    return element_forces(vertex_count, tets, gradients, volumes, rotations)


def arap_energy(rest: np.ndarray, tets: np.ndarray, vertices: np.ndarray) -> float:
    """sum over tets of |tet| min_R |R - L|_F^2 (P A.2), in cubic metres."""
    linear = deformation_gradients(vertices, tets, tet_gradients(rest, tets))
    return float(np.abs(tet_volumes(rest, tets)) @ ((fit_rotations(linear) - linear) ** 2).sum((1, 2)))


class HeldArap:
    """Local/global ARAP with some vertices held: factor once for a rest shape and a held set, solve many.

    ``rest`` (c, 3) float64, ``tets`` (q, 4) int32, ``held`` indices into the c vertices; every connected component
    needs at least one held vertex, otherwise ValueError.
    """

    def __init__(self, rest: np.ndarray, tets: np.ndarray, held: np.ndarray):
        self.tets = tets
        self.gradients, self.volumes = tet_gradients(rest, tets), np.abs(tet_volumes(rest, tets))
        self.held = np.unique(held)
        self.free = np.setdiff1d(np.arange(len(rest)), self.held)
        stiffness = arap_stiffness(rest, tets)
        self._coupling = stiffness[self.free][:, self.held]
        self._solver = SymmetricSolver(stiffness[self.free][:, self.free]) if len(self.free) else None

    def solve(self, initial: np.ndarray, iterations: int = 20) -> np.ndarray:
        """Vertices ``(c, 3)`` after so many local/global steps from ``initial``, whose held vertices stay."""
        vertices = np.array(initial, dtype=np.float64)
        if self._solver is None:
            return vertices
        fixed = self._coupling @ vertices[self.held]
        for _ in range(iterations):
            rotations = fit_rotations(deformation_gradients(vertices, self.tets, self.gradients))
            forces = arap_forces(len(vertices), self.tets, self.gradients, self.volumes, rotations)
            vertices[self.free] = self._solver.solve(forces[self.free] - fixed)
        return vertices
