import numpy as np
import pytest
import scipy.sparse as sp

from unstructured_mg.geometry.conjugate import TwoLevel, conjugate_gradients


def test_agrees_with_a_dense_solve_from_any_start():
    root = sp.random(80, 80, 0.1, random_state=0)
    matrix = (root @ root.T + sp.eye(80)).tocsr()
    right = np.random.default_rng(0).normal(size=(80, 3))
    truth = np.linalg.solve(matrix.toarray(), right)
    for start in (None, right):
        answer = conjugate_gradients(matrix, right, start, tolerance=1e-12)
        np.testing.assert_allclose(answer, truth, atol=1e-9)
    np.testing.assert_allclose(conjugate_gradients(matrix, right[:, 0], tolerance=1e-12), truth[:, 0], atol=1e-9)


def test_the_answer_of_the_negated_right_side_is_the_negated_answer():
    matrix = sp.diags([np.full(50, 2.1), np.full(49, -1.0), np.full(49, -1.0)], [0, 1, -1]).tocsr()
    right = np.random.default_rng(1).normal(size=50)
    np.testing.assert_array_equal(
        conjugate_gradients(matrix, -right, tolerance=1e-3), -conjugate_gradients(matrix, right, tolerance=1e-3)
    )


def test_systems_that_cannot_be_positive_definite_are_refused():
    with pytest.raises(ValueError, match="diagonal"):
        conjugate_gradients(sp.diags([1.0, 0.0]).tocsr(), np.ones(2))
    with pytest.raises(ValueError, match="rows"):
        conjugate_gradients(sp.eye(3).tocsr(), np.ones(2))


def test_a_coarse_level_saves_most_iterations():
    size = 400
    matrix = sp.diags([np.full(size, 2.0 + 1e-4), np.full(size - 1, -1.0), np.full(size - 1, -1.0)], [0, 1, -1]).tocsr()
    right = np.random.default_rng(0).normal(size=size)
    truth = np.linalg.solve(matrix.toarray(), right)
    clusters = sp.csr_matrix((np.ones(size), (np.arange(size), np.arange(size) // 8)))
    coarse = TwoLevel(matrix, clusters)
    with_coarse = conjugate_gradients(matrix, right, tolerance=1e-12, most=60, precondition=coarse)
    without = conjugate_gradients(matrix, right, tolerance=1e-12, most=60)
    np.testing.assert_allclose(with_coarse, truth, atol=1e-5 * np.abs(truth).max())
    assert np.abs(without - truth).max() > 0.1 * np.abs(truth).max()
