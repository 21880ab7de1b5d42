"""The volume behind a tracked surface (P section 5.6): cage vertices by volumetric ARAP with the surface held."""

import numpy as np

from unstructured_mg.geometry.means import weighted_means
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.tracking.embedding import Cage
from unstructured_mg.tracking.system import CageSystem

_AXES = np.eye(3)


class Interior:
    """Cage vertices minimising sum a_i |p_i(x) - v_i|^2 + softness L^2 / V E_ARAP(rest, x), prepared once for a cage.

    The surface lies inside the cage rather than on its boundary, so it holds the cage softly: p_i is the embedded
    surface, v_i the tracked one, a_i shares of area. What remains is the tracked pair's residual.
    """

    def __init__(self, cage: Cage, system: CageSystem, areas: np.ndarray, scale: float, softness: float):
        self.cage, self.system = cage, system
        self._shares = areas / areas.sum()
        self._corners = cage.tets[cage.tet_of_vertex]
        self._strength = softness * scale**2 / system.volumes.sum()
        self._held, unused = system.new_terms()
        for axis in _AXES:
            planes = np.tile(axis, (len(areas), 1))
            system.add_planes(
                self._held, unused, cage.tet_of_vertex, cage.weights, planes, self._shares, np.zeros(len(areas))
            )

    def fit(self, vertices: np.ndarray, surface: np.ndarray, iterations: int) -> np.ndarray:
        """Cage vertices (c, 3) from a start (c, 3) in whose tets the surface (n, 3) lies; no tet is inverted by it."""
        cage, system = self.cage, self.system
        floor = np.minimum(0.05 * system.volumes, 0.5 * np.maximum(tet_volumes(vertices, cage.tets), 0))
        strength = np.full(len(cage.tets), self._strength)
        for _ in range(iterations):
            carried = weighted_means(cage.tets, cage.tet_of_vertex, cage.weights, vertices)
            if cage.residual.any():
                _, rotations = system.rotations(vertices)
                carried += np.einsum("nab,nb->na", rotations[cage.tet_of_vertex], cage.residual)
            pull = (self._shares[:, None] * (surface - carried))[:, None, :] * cage.weights[:, :, None]
            blocks, right = self._held.copy(), system.scatter(self._corners, pull)
            system.add_arap(blocks, right, vertices, strength)
            step = system.solve(blocks, right, 1e-9 * blocks[:, [0, 4, 8]].max())
            share = 1.0
            while share > 1e-3 and (tet_volumes(vertices + share * step, cage.tets) < floor).any():
                share *= 0.5
            if share > 1e-3:
                vertices = vertices + share * step
        return vertices
