"""Factor once, solve many: sparse symmetric positive definite systems."""

import numpy as np
import scipy.sparse as sp
from cholespy import CholeskySolverD, MatrixType


class SymmetricSolver:
    """Cholesky factors of a sparse symmetric positive definite matrix (n, n) float64.

    Raises ValueError where the matrix is not square, not finite or not positive definite.
    """

    def __init__(self, matrix: sp.spmatrix):
        matrix = sp.csr_matrix(matrix, dtype=np.float64, copy=True)
        if matrix.shape[0] != matrix.shape[1]:
            raise ValueError(f"matrix: expected a square matrix, got shape {matrix.shape}")
        if not np.isfinite(matrix.data).all():
            raise ValueError("matrix: expected finite entries, got NaN or infinity")
        matrix.sum_duplicates()
        self.size = matrix.shape[0]
        # By rows, because the solver calls realloc on the memory of a matrix by columns, which is not its own; rows it
        # only reads.
        self._solver = CholeskySolverD(
            self.size,
            matrix.indptr.astype(np.int32),
            matrix.indices.astype(np.int32),
            matrix.data,
            MatrixType.CSR,
        )

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve for ``right`` of shape (n,) or (n, d); the answer has the same shape."""
        right = np.ascontiguousarray(right, dtype=np.float64)
        if right.shape[0] != self.size:
            raise ValueError(f"right: expected {self.size} rows, got shape {right.shape}")
        columns = right.reshape(self.size, -1)
        answer = np.zeros_like(columns)
        self._solver.solve(columns, answer)
        return answer.reshape(right.shape)
