import dataclasses

import numpy as np
import pytest
from scipy.optimize import minimize
from toy_pair import bend, club, lattice

from unstructured_mg.geometry.elements import two_sided_targets
from unstructured_mg.geometry.tets import deformation_gradients, tet_gradients, tet_volumes
from unstructured_mg.synthesis.blend_volumetric_arap import VolumetricArapBlend
from unstructured_mg.synthesis.posture import Posture, Template


def block() -> Template:
    """Four cells that carry a surface of four triangles."""
    cage, tets = lattice(np.linspace(0, 0.2, 2), np.linspace(0, 0.2, 2), np.linspace(0, 0.8, 5))
    corners = np.array([[0.05, 0.05, 0.1], [0.15, 0.05, 0.1], [0.05, 0.15, 0.1], [0.05, 0.05, 0.7]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)
    return Template(corners, faces, cage, tets, np.zeros(4, np.int32), np.tile([1.0, 0, 0, 0], (4, 1)), corners[None])


def test_no_minimiser_finds_less_energy():
    template = block()
    source, target, weight = bend(template.cage, 0.3), bend(template.cage, 1.5), 0.4
    gradients, volumes = tet_gradients(template.cage, template.tets), tet_volumes(template.cage, template.tets)
    shapes = [deformation_gradients(cage, template.tets, gradients) for cage in (source, target)]

    def energy(cage):
        new = deformation_gradients(cage.reshape(-1, 3), template.tets, gradients)
        total = 0.0
        for share, shape in ((1 - weight, shapes[0]), (weight, shapes[1])):
            turned = two_sided_targets(new, shape, shape, 0.0)
            total += share * volumes @ ((turned - new) ** 2).sum((1, 2))
        return total

    surface = template.surface
    blend = VolumetricArapBlend(template, cage_iterations=300, keep_volume=False)
    found = blend(Posture(surface, source), Posture(surface, target), weight).cage
    start = (1 - weight) * source + weight * target
    best = minimize(energy, start.ravel(), method="BFGS", options={"maxiter": 400, "gtol": 1e-9}).fun
    assert energy(found) <= best * (1 + 1e-4)
    # Four iterations, as blends use, are nearly there.
    quick = VolumetricArapBlend(template, keep_volume=False)(Posture(surface, source), Posture(surface, target), weight)
    assert energy(quick.cage) <= 1.05 * best


def test_cells_keep_the_blend_of_their_volumes():
    template = club()
    # Bent at different heights: no bend is half-way, and a mean of shapes is too large.
    wide, thin = template.cage * [1.3, 0.8, 1.0], template.cage * [0.8, 1.3, 1.0]
    source = Posture(template.surface * [1.3, 0.8, 1.0], wide)
    target = Posture(template.surface * [0.8, 1.3, 1.0], thin)
    volumes = []
    for keep in (True, False):
        cage = VolumetricArapBlend(template, keep_volume=keep)(source, target, 0.5).cage
        volumes.append(tet_volumes(cage, template.tets).sum())
    expected = (tet_volumes(wide, template.tets).sum() + tet_volumes(thin, template.tets).sum()) / 2
    np.testing.assert_allclose(volumes[0], expected, rtol=1e-3)
    np.testing.assert_allclose(volumes[1], expected * 1.05**2 / 1.04, rtol=1e-3)


def test_a_cell_turned_inside_out_at_one_end_breaks_nothing():
    template = club()
    cage = template.cage.copy()
    cage[0] += [0.2, 0.2, 0.2]
    assert tet_volumes(cage, template.tets).min() < 0
    source, target = Posture(template.surface, cage), Posture(template.surface, template.cage)
    blend = VolumetricArapBlend(template)
    for weight in (0.0, 0.3, 1.0):
        assert np.isfinite(blend(source, target, weight).surface).all()
    np.testing.assert_allclose(blend(source, target, 0.0).surface, source.surface, atol=1e-9)


def test_vertices_of_no_triangle_are_carried_along():
    template = club()
    loose = dataclasses.replace(
        template,
        surface=np.vstack([template.surface, template.surface[:1]]),
        tet_of_vertex=np.append(template.tet_of_vertex, template.tet_of_vertex[:1]),
        weights=np.vstack([template.weights, template.weights[:1]]),
    )
    source = Posture(bend(loose.surface, 0.1), bend(loose.cage, 0.1))
    target = Posture(bend(loose.surface, 0.8), bend(loose.cage, 0.8))
    middle = VolumetricArapBlend(loose)(source, target, 0.5).surface
    np.testing.assert_allclose(middle[-1], middle[0], atol=2e-3)


def test_a_cage_is_needed():
    template = club()
    with pytest.raises(ValueError, match="cage"):
        VolumetricArapBlend(template)(Posture(template.surface, None), Posture(template.surface, template.cage), 0.5)
