import numpy as np
from scipy.spatial.transform import Rotation
from toy_pair import club

from unstructured_mg.geometry.laplacian import stiffness_matrix
from unstructured_mg.geometry.triangles import TriangleElements


def test_a_turn_and_stretch_is_read_off_every_triangle():
    template = club()
    elements = TriangleElements(template.surface, template.faces)
    turn = Rotation.from_rotvec([0.3, -0.5, 1.0]).as_matrix()
    found = elements.deformation(template.surface @ (2 * turn).T + 5)
    # Normals are turned but keep unit length.
    normal = np.einsum("ma,mb->mab", elements.normals @ turn.T, elements.normals)
    np.testing.assert_allclose(found, 2 * turn[None] - normal, atol=1e-10)


def test_divergence_of_the_deformation_is_the_laplacian():
    template = club()
    elements = TriangleElements(template.surface, template.faces)
    vertices = np.random.default_rng(0).normal(size=template.surface.shape)
    stiffness = stiffness_matrix(template.surface, template.faces)
    np.testing.assert_allclose(elements.divergence(elements.tangential(vertices)), stiffness @ vertices, atol=1e-9)
    np.testing.assert_allclose(elements.divergence(elements.deformation(vertices)), stiffness @ vertices, atol=1e-9)


def test_triangles_without_area_pull_at_nothing():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]])
    elements = TriangleElements(vertices, np.array([[0, 1, 2], [0, 1, 3], [2, 2, 1]], np.int32))
    np.testing.assert_array_equal(elements.areas, [0.5, 0, 0])
    assert np.isfinite(elements.deformation(vertices)).all()
    np.testing.assert_array_equal(elements.divergence(np.ones((3, 3, 3)))[3], 0)
