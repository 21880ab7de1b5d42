"""Conjugate gradients: for systems that are solved once, where factors would cost more than the answer."""

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp

from unstructured_mg.geometry.solver import SymmetricSolver


class TwoLevel:
    """An additive two-level preconditioner: the diagonal, and the exact answer in a coarse space.

    Where neighbouring unknowns are strongly coupled, conjugate gradients then take some tens of iterations instead of
    many hundreds. Call it on a residual (n,).

    matrix (n, n) sparse symmetric positive definite; prolong (n, k) sparse with independent columns, each a smooth (or
    constant) vector on a cluster of unknowns.
    """

    def __init__(self, matrix: sp.csr_matrix, prolong: sp.csr_matrix):
        self._inverse = 1 / matrix.diagonal()
        self._prolong = prolong
        self._restrict = prolong.T.tocsr()
        self._coarse = SymmetricSolver(self._restrict @ matrix @ prolong)

    def __call__(self, residual: np.ndarray) -> np.ndarray:
        answer = self._prolong @ self._coarse.solve(self._restrict @ residual)
        answer += self._inverse * residual
        return answer


def conjugate_gradients(
    matrix: sp.csr_matrix,
    right: np.ndarray,
    start: np.ndarray | None = None,
    tolerance: float = 1e-6,
    most: int = 2000,
    precondition: Callable[[np.ndarray], np.ndarray] | None = None,
) -> np.ndarray:
    """Solve a sparse symmetric positive definite system by preconditioned conjugate gradients.

    Parameters
    ----------
    matrix : (n, n) float64 with a positive diagonal
    right : (n,) or (n, d) float64
    start : first guess, shaped like ``right``; zero if None
    tolerance : stop where the preconditioned residual is this fraction of the right side's
    most : stop after so many iterations
    precondition : symmetric positive definite map of residuals (n,), say a ``TwoLevel``; the diagonal if None

    Returns
    -------
    The answer, shaped like ``right``. The answer for ``-right`` is exactly its negative.

    Raises ValueError where shapes do not fit or the diagonal is not positive.
    """
    matrix = sp.csr_matrix(matrix, dtype=np.float64)
    size = matrix.shape[0]
    if matrix.shape != (size, size) or right.shape[0] != size:
        raise ValueError(f"matrix, right: expected (n, n) and n rows, got {matrix.shape} and {right.shape}")
    diagonal = matrix.diagonal()
    if not (diagonal > 0).all():
        raise ValueError("matrix: expected a positive diagonal")
    inverse = 1 / diagonal
    apply = precondition or (lambda residual: inverse * residual)
    # Each column on its own: its vectors then stay in the cache.
    columns = np.ascontiguousarray(np.asarray(right, np.float64).reshape(size, -1).T)
    answer = np.zeros_like(columns)
    if start is not None:
        answer[:] = np.asarray(start, np.float64).reshape(size, -1).T
    for column, x in zip(columns, answer, strict=True):
        _solve_column(matrix, column, x, tolerance, most, apply)
    return answer.T.reshape(np.shape(right)).copy()


def _solve_column(
    matrix: sp.csr_matrix,
    right: np.ndarray,
    x: np.ndarray,
    tolerance: float,
    most: int,
    precondition: Callable[[np.ndarray], np.ndarray],
) -> None:
    residual = right - matrix @ x
    scaled = precondition(residual)
    energy = _inner(residual, scaled)
    goal = tolerance**2 * _inner(right, precondition(right))
    direction, work = scaled.copy(), np.empty_like(x)
    for _ in range(most):
        if energy <= goal:
            return
        image = matrix @ direction
        step = energy / _inner(direction, image)
        x += np.multiply(direction, step, out=work)
        image *= step
        residual -= image
        scaled = precondition(residual)
        following = _inner(residual, scaled)
        direction *= following / energy
        direction += scaled
        energy = following


def _inner(a: np.ndarray, b: np.ndarray) -> float:
    # Not BLAS: its sums depend on the number of threads.
    return float(np.einsum("i,i->", a, b))
