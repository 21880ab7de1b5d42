import numpy as np
from scipy.spatial import Delaunay

from unstructured_mg.geometry.tets import barycentric, deformation_gradients, tet_gradients, tet_volumes


def filled_box(seed=0):
    """Tets that fill the box (1, 2, 3), some of them turned inside out."""
    random = np.random.default_rng(seed)
    corners = np.array(np.meshgrid([0, 1], [0, 2], [0, 3])).reshape(3, -1).T
    vertices = np.vstack([corners, random.random((20, 3)) * (1, 2, 3)])
    return vertices, Delaunay(vertices).simplices.astype(np.int32)


def test_volumes_fill_the_box_and_change_sign_with_the_orientation():
    vertices, tets = filled_box()
    volumes = tet_volumes(vertices, tets)
    np.testing.assert_allclose(np.abs(volumes).sum(), 6, rtol=1e-12)
    np.testing.assert_allclose(tet_volumes(vertices, tets[:, [1, 0, 2, 3]]), -volumes, rtol=1e-9, atol=1e-12)
    unit = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    np.testing.assert_allclose(tet_volumes(unit, np.array([[0, 1, 2, 3]], np.int32)), 1 / 6)


def test_gradients_are_exact_for_linear_functions():
    vertices, tets = filled_box()
    slope = np.array([0.3, -2.0, 5.0])
    values = vertices @ slope + 7
    found = np.einsum("qki,qk->qi", tet_gradients(vertices, tets), values[tets])
    np.testing.assert_allclose(found, np.broadcast_to(slope, found.shape), atol=1e-6)


def test_an_affine_map_is_every_tets_deformation_gradient():
    vertices, tets = filled_box()
    linear = np.random.default_rng(1).normal(size=(3, 3))
    moved = vertices @ linear.T + (1, 2, 3)
    found = deformation_gradients(moved, tets, tet_gradients(vertices, tets))
    np.testing.assert_allclose(found, np.broadcast_to(linear, found.shape), atol=1e-6)


def test_barycentric_weights_give_the_point_back_and_are_negative_outside():
    vertices, tets = filled_box()
    random = np.random.default_rng(2)
    of_point = random.integers(len(tets), size=50)
    weights = random.dirichlet(np.ones(4), 50)
    inside = np.einsum("pk,pki->pi", weights, vertices[tets[of_point]])
    np.testing.assert_allclose(barycentric(vertices, tets, inside, of_point), weights, atol=1e-6)
    outside = barycentric(vertices, tets, inside + (0, 0, 9), of_point)
    assert (outside.min(1) < 0).all()
    np.testing.assert_allclose(outside.sum(1), 1)
