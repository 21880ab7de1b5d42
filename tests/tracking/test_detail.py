import igl
import numpy as np
from scipy.spatial.transform import Rotation

from unstructured_mg.geometry.laplacian import mass_matrix, stiffness_matrix
from unstructured_mg.geometry.normals import vertex_normals
from unstructured_mg.tracking.detail import detail_layers, normal_offsets, smooth_normals, transfer_detail
from unstructured_mg.tracking.options import TrackingOptions


def sphere(level):
    vertices, faces = igl.icosahedron()
    for _ in range(level):
        vertices, faces = igl.upsample(vertices, faces)
        vertices = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    return vertices, np.ascontiguousarray(faces, np.int32)


def bumps(points, depth, pitch=7):
    waves = np.sin(pitch * points[:, :1]) * np.sin(pitch * points[:, 1:2] + 1) * np.cos(pitch * points[:, 2:])
    return points * (1 + depth * waves)


def test_smoothing_leaves_the_energy_no_way_down():
    V, F = sphere(3)
    V = bumps(V, 0.05)
    n, M, S = vertex_normals(V, F), mass_matrix(V, F).diagonal(), stiffness_matrix(V, F).tocsr()
    weight = 0.02

    def energy(t):
        return M @ (t**2).sum(1) + weight * np.einsum("nx,nx->", n + t, S @ (n + t))

    rng = np.random.default_rng(0)
    # The smoothed normals are (n + t) / |n + t| with t in the tangent planes: t is recovered from them.
    smooth = smooth_normals(n, M, S, weight, 1e-10)
    t = smooth / np.einsum("nx,nx->n", smooth, n)[:, None] - n
    assert energy(t) < energy(np.zeros_like(t))
    for _ in range(5):
        other = rng.normal(size=t.shape) * 1e-4
        other -= np.einsum("nx,nx->n", other, n)[:, None] * n
        slope = (energy(t + other) - energy(t - other)) / 2
        assert abs(slope) < 1e-6 * (energy(t + other) + energy(t - other) - 2 * energy(t))


def test_offsets_solve_their_system_and_have_zero_mean():
    V, F = sphere(3)
    V = bumps(V, 0.05)
    n, M, S = vertex_normals(V, F), mass_matrix(V, F).diagonal(), stiffness_matrix(V, F)
    weight = 0.01
    N = np.zeros((3 * len(V), len(V)))
    for a in range(3):
        N[a * len(V) : (a + 1) * len(V)] = np.diag(n[:, a])
    system = N.T @ np.kron(np.eye(3), np.diag(M) + weight * S.toarray()) @ N
    expected = np.linalg.solve(system, -weight * N.T @ (S @ V).T.ravel())
    expected -= M @ expected / M.sum()
    np.testing.assert_allclose(normal_offsets(V, n, M, S.tocsr(), weight, 1e-12), expected, atol=1e-9)


def test_on_a_sphere_all_layers_are_the_sphere():
    # By symmetry the smoothed normals stay radial and the zero-mean offsets vanish.
    V, F = sphere(4)
    layers = detail_layers(V, F, TrackingOptions())
    assert np.abs(layers.offsets).max() < 1e-3
    assert np.abs(np.linalg.norm(layers.base, axis=1) - 1).max() < 2e-3


def test_a_bumped_spheres_detail_goes_to_another_mesh_of_the_sphere():
    plain, faces = sphere(5)
    turned = plain @ Rotation.from_rotvec([0.3, 0.5, 0.7]).as_matrix()
    # Fine bumps: detail at the smoothing weight's scale (root of 1e-4 of the area) and below.
    moved = transfer_detail(plain, faces, bumps(turned, 0.004, 25), faces, TrackingOptions())
    before, after = (np.linalg.norm(points - bumps(plain, 0.004, 25), axis=1) for points in (plain, moved))
    assert np.sqrt(np.mean(after**2)) < np.sqrt(np.mean(before**2)) / 3
