import numpy as np
import trimesh

from unstructured_mg.geometry.laplacian import mass_matrix, stiffness_matrix


def test_mass_sums_to_the_area():
    mesh = trimesh.creation.icosphere(subdivisions=3)
    np.testing.assert_allclose(mass_matrix(mesh.vertices, mesh.faces).sum(), mesh.area)


def test_stiffness_gives_the_dirichlet_energy_of_a_linear_function():
    # On a plane |grad (3x + 4y)|^2 = 25 everywhere.
    rng = np.random.default_rng(0)
    from scipy.spatial import Delaunay

    points = rng.random((200, 2))
    faces = Delaunay(points).simplices
    vertices = np.column_stack([points, np.zeros(200)])
    f = points @ [3.0, 4.0]
    area = mass_matrix(vertices, faces).sum()
    np.testing.assert_allclose(f @ stiffness_matrix(vertices, faces) @ f, 25 * area)


def test_zero_area_faces_change_nothing():
    mesh = trimesh.creation.icosphere(subdivisions=1)
    faces = np.vstack([mesh.faces, [[0, 0, 1], [2, 2, 2]]])
    plain, with_slivers = (stiffness_matrix(np.asarray(mesh.vertices), f) for f in (mesh.faces, faces))
    np.testing.assert_allclose(with_slivers.toarray(), plain.toarray())
