import numpy as np
from tracking.bodies import bend, figure

from unstructured_mg.geometry.arap import arap_energy
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.tracking.cage_lattice import lattice_cage
from unstructured_mg.tracking.embedding import make_cage
from unstructured_mg.tracking.interior import Interior
from unstructured_mg.tracking.surface import vertex_areas
from unstructured_mg.tracking.system import CageSystem


def test_the_cage_follows_a_bent_surface_at_an_energy_minimum():
    vertices, faces = figure(36, 50)
    cage = make_cage(
        *lattice_cage(vertices, faces, 0.12)[:2], vertices, lattice_cage(vertices, faces, 0.12)[2], "lattice"
    )
    areas, softness = vertex_areas(vertices, faces), 1e-6
    system = CageSystem(cage.vertices, cage.tets)
    bent = bend(vertices, 0.5)
    fitted = Interior(cage, system, areas, 1.0, softness).fit(bend(cage.vertices, 0.4), bent, 30)

    def energy(x):
        carried = np.einsum("ni,nix->nx", cage.weights, x[cage.tets[cage.tet_of_vertex]])
        held = areas / areas.sum() @ ((carried - bent) ** 2).sum(1)
        return held + softness / system.volumes.sum() * arap_energy(cage.vertices, cage.tets, x)

    carried = np.einsum("ni,nix->nx", cage.weights, fitted[cage.tets[cage.tet_of_vertex]])
    assert np.linalg.norm(carried - bent, axis=1).max() < 4e-3
    assert tet_volumes(fitted, cage.tets).min() > 0
    rng = np.random.default_rng(0)
    for _ in range(5):
        other = rng.normal(size=fitted.shape) * 1e-5
        slope, curve = energy(fitted + other) - energy(fitted - other), energy(fitted + other) + energy(fitted - other)
        assert abs(slope) < 1e-2 * (curve - 2 * energy(fitted))
