import numpy as np
import pytest
import scipy.sparse as sp

from unstructured_mg.geometry.solver import SymmetricSolver


def test_agrees_with_a_dense_solve():
    root = sp.random(80, 80, 0.1, random_state=0)
    matrix = root @ root.T + sp.eye(80)
    right = np.random.default_rng(0).normal(size=(80, 4))
    solver = SymmetricSolver(matrix)
    np.testing.assert_allclose(solver.solve(right), np.linalg.solve(matrix.toarray(), right), atol=1e-10)
    np.testing.assert_allclose(solver.solve(right[:, 0]), np.linalg.solve(matrix.toarray(), right[:, 0]), atol=1e-10)


@pytest.mark.parametrize("matrix", [-sp.eye(4), sp.csc_matrix((3, 4)), sp.diags([1.0, np.nan])])
def test_matrices_without_a_cholesky_factor_are_refused(matrix):
    with pytest.raises(ValueError):
        SymmetricSolver(matrix)
