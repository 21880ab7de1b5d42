"""Conjugate gradients: for systems that are solved once, where factors would cost more than the answer."""

import numpy as np
import scipy.sparse as sp

from unstructured_mg import _native


def conjugate_gradients(
    matrix: sp.csr_matrix, right: np.ndarray, start: np.ndarray | None = None, tolerance: float = 1e-6, most: int = 2000
) -> np.ndarray:
    """Solve a sparse symmetric positive definite system by Jacobi-preconditioned conjugate gradients.

    Parameters
    ----------
    matrix : (n, n) float64 with a positive diagonal
    right : (n,) or (n, d) float64
    start : first guess, shaped like ``right``; zero if None
    tolerance : stop where the preconditioned residual is this fraction of the right side's
    most : stop after so many iterations

    Returns
    -------
    The answer, shaped like ``right``.

    Raises ValueError where shapes do not fit or the diagonal is not positive.
    """
    matrix = sp.csr_matrix(matrix, dtype=np.float64)
    size = matrix.shape[0]
    if matrix.shape != (size, size) or right.shape[0] != size:
        raise ValueError(f"matrix, right: expected (n, n) and n rows, got {matrix.shape} and {right.shape}")
    diagonal = matrix.diagonal()
    if not (diagonal > 0).all():
        raise ValueError("matrix: expected a positive diagonal")
    columns = np.ascontiguousarray(np.asarray(right, np.float64).reshape(size, -1).T)
    answer = np.zeros_like(columns)
    if start is not None:
        answer[:] = np.asarray(start, np.float64).reshape(size, -1).T
    indptr, indices = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32)
    for column, x in zip(columns, answer, strict=True):
        _native.conjugate_gradients(
            size, matrix.nnz, indptr, indices, matrix.data, 1 / diagonal, column, tolerance, most, x
        )
    return answer.T.reshape(np.shape(right)).copy()
