import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla
import trimesh
from textured_pairs import grid, pattern

from unstructured_mg.geometry.tracing import TracingSurface
from unstructured_mg.synthesis.flow import FlowSolver
from unstructured_mg.synthesis.project import smooth_normals
from unstructured_mg.synthesis.texture_options import TextureOptions


def solver_of(vertices, faces):
    return FlowSolver(vertices, smooth_normals(vertices, faces), TracingSurface(vertices, faces))


@pytest.fixture(scope="module")
def sphere():
    mesh = trimesh.creation.icosphere(subdivisions=5)
    return solver_of(np.asarray(mesh.vertices), mesh.faces.astype(np.int32)), np.asarray(mesh.vertices)


def turned(points, angle):
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return points @ turn.T


def in_space(solver, field):
    return np.einsum("na,nac->nc", field, solver.fields.axes)


def test_a_turning_texture_is_found_on_a_sphere(sphere):
    solver, vertices = sphere
    angle = 0.12
    paint = lambda points: pattern(points, finest=12)  # noqa: E731
    start, end = paint(turned(vertices, angle / 2)), paint(turned(vertices, -angle / 2))
    flow = solver.estimate(start, end, TextureOptions())
    truth = angle * np.cross([0, 0, 1.0], vertices)
    error = np.linalg.norm(in_space(solver, flow.field) - truth, axis=1)
    assert error.mean() < 0.05 * angle and flow.residual_after < 0.12 * flow.residual_before
    assert flow.unexplained == 0


def test_swapped_ends_give_the_negated_flow(sphere):
    solver, vertices = sphere
    start, end = pattern(turned(vertices, 0.03), finest=12), pattern(turned(vertices, -0.03), finest=12)
    one, other = (solver.estimate(a, b, TextureOptions(levels=3)) for a, b in ((start, end), (end, start)))
    np.testing.assert_allclose(one.field, -other.field, atol=1e-9)
    np.testing.assert_allclose(one.confidence, other.confidence, atol=1e-9)


def test_equal_ends_stand_still(sphere):
    solver, vertices = sphere
    paint = pattern(vertices, finest=12)
    flow = solver.estimate(paint, paint, TextureOptions(levels=2))
    assert (flow.field == 0).all() and flow.residual_after == 0 and flow.unexplained == 0


def test_size_does_not_matter():
    vertices, faces = grid(24, 24)
    shift = np.array([0.03, -0.02])
    fields = []
    for size in (1.0, 7.0):
        solver = solver_of(vertices * size, faces)
        start, end = (pattern(vertices[:, :2] + s * shift / 2, finest=8) for s in (1, -1))
        fields.append(in_space(solver, solver.estimate(start, end, TextureOptions(levels=4)).field) / size)
    np.testing.assert_allclose(fields[0], fields[1], atol=1e-6)
    middle = np.abs(vertices[:, :2] - 0.5).max(axis=1) < 0.4
    assert np.linalg.norm(fields[0][middle, :2] - shift, axis=1).mean() < 0.1 * np.linalg.norm(shift)


def test_detail_that_appears_is_not_explained_by_flow(sphere):
    solver, vertices = sphere
    paint = 128 + 0.2 * (pattern(vertices, finest=10) - 128)
    spot = np.exp(-((vertices - [1, 0, 0]) ** 2).sum(axis=1) / 0.3**2)[:, None]
    noisy = pattern(vertices, seed=5, finest=40) - 128
    flow = solver.estimate(paint, paint + spot * noisy * 2, TextureOptions())
    near, far = spot[:, 0] > 0.8, spot[:, 0] < 1e-4
    assert flow.confidence[near].mean() < 0.5 and flow.confidence[far].min() > 0.99
    assert 0 < flow.unexplained < 0.2
    assert flow.residual_after <= flow.residual_before * 1.001


def test_smoothing_solves_the_screened_poisson_equation(sphere):
    solver, vertices = sphere
    signal = pattern(vertices)
    answer = solver.smooth(signal, 0.01, 1e-10)
    matrix = (sp.diags(solver.masses) + 0.01 * solver.stiffness).tocsc()
    truth = spla.spsolve(matrix, solver.masses[:, None] * signal)
    np.testing.assert_allclose(answer, truth, atol=1e-5)


def test_without_flow_nothing_moves(sphere):
    solver, vertices = sphere
    flow = solver.standing(pattern(vertices), pattern(vertices, seed=1))
    assert not flow.corners.any() and flow.residual_after == flow.residual_before and flow.unexplained == 1


def test_a_level_minimises_the_energy_of_the_paper(sphere):
    solver, vertices = sphere
    first, second = pattern(turned(vertices, 0.01), finest=12), pattern(turned(vertices, -0.01), finest=12)
    weight = 2e4
    faces, areas = solver.tracing.faces, solver.tracing.areas
    slopes = [np.einsum("fid,fic->fcd", solver.tracing.gradients(), s[faces]) for s in (first, second)]
    change = (first - second)[faces].mean(axis=1)

    def energy(field):
        middle = solver.fields.at_corners(field, faces).mean(axis=1)
        misses = [(np.einsum("fcd,fd->fc", slope, middle) - change) ** 2 for slope in slopes]
        flat = field.ravel()
        return areas @ sum(misses).sum(axis=1) + weight * (flat @ solver.fields.stiffness @ flat)

    answer = solver._correction(first, second, weight, 1e-8)
    # The answer is scaled to undo what smoothing damps (eq. 8): the minimum lies on the ray through it.
    shares = np.linspace(0.2, 1.2, 401)
    best = shares[np.argmin([energy(share * answer) for share in shares])] * answer
    generator = np.random.default_rng(0)
    for _ in range(5):
        aside = generator.normal(size=best.shape) * np.abs(best).mean()
        assert energy(best + 0.01 * aside) > energy(best)
        assert abs(energy(best + 1e-4 * aside) - energy(best - 1e-4 * aside)) < 1e-4 * energy(best)
    unscaled = [np.einsum("fcd,fd->fc", s, solver.fields.at_corners(answer, faces).mean(axis=1)) for s in slopes]
    gain = sum(areas @ (u * change).sum(axis=1) for u in unscaled)
    np.testing.assert_allclose(gain, sum(areas @ (u**2).sum(axis=1) for u in unscaled), rtol=1e-6)
