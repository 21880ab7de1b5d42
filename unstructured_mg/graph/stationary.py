"""Long-run visits of a Markov chain on a multigraph, and their adjoint."""

import numpy as np
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu


class Chain:
    """The pattern of a chain: what can be prepared before the probabilities are known.

    Parameters
    ----------
    source, target : (E,) int, the nodes that edge e joins; parallel edges and loops are welcome
    nodes : number of nodes N; the chain must be irreducible for the probabilities it is solved with
    """

    def __init__(self, source: np.ndarray, target: np.ndarray, nodes: int) -> None:
        self.source, self.target, self.nodes = np.asarray(source), np.asarray(target), nodes
        # Node 0 is held at 1. For the others (I - P')^T u = (row 0 of P): an M-matrix, so elimination loses no digits
        # to cancellation and a sparse graph stays sparse, unlike with a dense row for "probabilities sum to one".
        inner = (self.source > 0) & (self.target > 0)
        self._inner, self._from_first = np.flatnonzero(inner), np.flatnonzero((self.source == 0) & (self.target > 0))
        size = nodes - 1
        rows = np.concatenate([np.arange(size), self.target[self._inner] - 1])
        columns = np.concatenate([np.arange(size), self.source[self._inner] - 1])
        keys, self._slot = np.unique(columns * max(size, 1) + rows, return_inverse=True)
        self._rows = (keys % max(size, 1)).astype(np.int32)
        self._starts = np.searchsorted(keys, np.arange(nodes) * max(size, 1)).astype(np.int32)

    def solve(self, probabilities: np.ndarray) -> "Stationary":
        """Visits for (E,) probabilities that sum to one over each node's out-edges."""
        size = self.nodes - 1
        visits = np.ones(self.nodes)
        if size == 0:
            return Stationary(visits, None)
        values = np.concatenate([np.ones(size), -probabilities[self._inner]])
        data = np.bincount(self._slot, weights=values, minlength=len(self._rows))
        factor = splu(csc_array((data, self._rows, self._starts), shape=(size, size)), permc_spec="MMD_AT_PLUS_A")
        start = self.target[self._from_first] - 1
        visits[1:] = factor.solve(np.bincount(start, weights=probabilities[self._from_first], minlength=size))
        return Stationary(visits, factor)


class Stationary:
    """A solved chain.

    Attributes
    ----------
    visits : (N,) float64, how often each node is visited for one visit of node 0
    """

    def __init__(self, visits: np.ndarray, factor: object) -> None:
        self.visits = visits
        self._factor = factor

    def adjoint(self, gradient: np.ndarray) -> np.ndarray:
        """(N,) multipliers m for a function with (N,) derivatives by ``visits``, one solve with the same factor.

        The function's derivative by the probability of an edge i -> j is ``visits[i] m[j]``, plus what it has directly.
        """
        multipliers = np.zeros(len(self.visits))
        if self._factor is not None:
            multipliers[1:] = self._factor.solve(gradient[1:], trans="T")  # type: ignore[attr-defined]
        return multipliers


def stationary_distribution(
    source: np.ndarray, target: np.ndarray, probabilities: np.ndarray, nodes: int
) -> np.ndarray:
    """(N,) float64 long-run probability of each node: the left eigenvector of P for eigenvalue one (P section 7.1)."""
    visits = Chain(source, target, nodes).solve(probabilities).visits
    return visits / visits.sum()
