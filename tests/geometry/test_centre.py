import numpy as np
import pytest

from unstructured_mg.geometry.centre import floor_centre

SQUARE = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], float)


def test_a_finer_mesh_of_a_part_moves_nothing():
    coarse = np.array([[0, 1, 2], [0, 2, 3]])
    finer = np.concatenate([SQUARE, [[1, 0, 0], [1, 1, 0]]])
    split = np.array([[0, 4, 5], [4, 1, 5], [1, 2, 5], [0, 5, 2], [0, 2, 3]])
    np.testing.assert_allclose(floor_centre(SQUARE, coarse), [1, 1])
    np.testing.assert_allclose(floor_centre(finer, split), [1, 1])


def test_large_surfaces_count_by_area_and_heights_for_nothing():
    far = SQUARE * 0.5 + [10, 0, 7]
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    both = np.concatenate([SQUARE, far]), np.concatenate([faces, faces + 4])
    np.testing.assert_allclose(floor_centre(*both), (4 * np.array([1, 1]) + np.array([10.5, 0.5])) / 5)


def test_a_surface_without_area_has_its_vertices_mean():
    line = np.array([[0, 0, 0], [1, 0, 0], [5, 0, 0]], float)
    assert floor_centre(line, np.array([[0, 1, 2]])) == pytest.approx([2, 0])
