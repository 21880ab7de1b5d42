import ctypes
import sys

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


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="asks glibc for the size of a block")
def test_the_callers_memory_keeps_its_size():
    """Sums of SciPy matrices own more memory than they show. Cut short, its next user breaks the heap."""
    usable = ctypes.CDLL(None).malloc_usable_size
    usable.argtypes, usable.restype = [ctypes.c_void_p], ctypes.c_size_t
    path = sp.diags([-np.ones(9), np.full(10, 2.0), -np.ones(9)], [-1, 0, 1]).tocsc()
    matrix = path + sp.diags(np.ones(10)).tocsc()
    owner = matrix.data.base
    assert owner.nbytes > matrix.data.nbytes
    SymmetricSolver(matrix)
    assert usable(owner.ctypes.data) >= owner.nbytes
