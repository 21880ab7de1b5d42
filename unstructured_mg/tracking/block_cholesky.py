"""Cholesky solves of sparse symmetric matrices of 3x3 blocks whose pattern stays and whose values change."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from unstructured_mg import _native

# A supernode takes in its last child while that makes few zeros explicit: dense kernels like larger fronts.
_SMALL, _ZEROS = 4, 0.1


class BlockCholesky:
    """The elimination order and fronts of a pattern, found once; ``solve`` then factors and solves for any values.

    ``pattern`` (b, 2) int are the (row, column) nodes of the stored blocks, row >= column, every diagonal block among
    them, none twice. General libraries find the order anew for every matrix; here that is four fifths of their time.
    """

    def __init__(self, count: int, pattern: np.ndarray):
        self.count = count
        order = _elimination_order(count, pattern)
        supernodes, rank = _supernodes(count, pattern, order)
        self.rank = rank
        owner = np.empty(count, np.int64)
        for index, (first, width, _) in enumerate(supernodes):
            owner[first : first + width] = index
        pivots = np.array([width for _, width, _ in supernodes], np.int32)
        others = np.array([len(rows) for _, _, rows in supernodes], np.int32)
        parent = np.array([owner[rows[0]] if len(rows) else -1 for _, _, rows in supernodes], np.int32)
        nodes = [np.concatenate([np.arange(first, first + width), rows]) for first, width, rows in supernodes]
        relative = [
            np.searchsorted(nodes[parent[i]], rows) if len(rows) else np.zeros(0, np.int64)
            for i, (_, _, rows) in enumerate(supernodes)
        ]
        high, low = rank[pattern[:, 0]], rank[pattern[:, 1]]
        transposed = high < low
        high, low = np.maximum(high, low), np.minimum(high, low)
        front = owner[low]
        by_front = np.argsort(front, kind="stable")
        starts = np.concatenate([[0], np.cumsum(np.bincount(front, minlength=len(supernodes)))])
        entries = np.empty((len(pattern), 4), np.int32)
        entries[:, 0], entries[:, 3] = by_front, transposed[by_front]
        for index, own in enumerate(nodes):
            part = by_front[starts[index] : starts[index + 1]]
            entries[starts[index] : starts[index + 1], 1] = np.searchsorted(own, high[part])
            entries[starts[index] : starts[index + 1], 2] = np.searchsorted(own, low[part])
        sizes = 3 * (pivots + others).astype(np.int64)
        self._symbolic = (
            pivots,
            others,
            parent,
            np.concatenate(relative).astype(np.int32),
            _starts(others),
            starts.astype(np.int32),
            entries,
            np.concatenate(nodes).astype(np.int32),
            _starts(pivots + others),
            _starts(sizes * 3 * pivots),
        )
        waiting = largest = 0
        for index in range(len(supernodes)):
            waiting -= int((9 * others[parent == index].astype(np.int64) ** 2).sum())
            waiting += int(9 * others[index].astype(np.int64) ** 2) if parent[index] >= 0 else 0
            largest = max(largest, waiting)
        self._sizes = (largest, int(sizes.max()), int((sizes * 3 * pivots).max()))
        factor = int((sizes * 3 * pivots).sum())
        self._work = np.empty(factor + self._sizes[0] + self._sizes[1] ** 2 + self._sizes[2] + self._sizes[1])

    def solve(self, blocks: np.ndarray, right: np.ndarray, damping: float = 0.0) -> np.ndarray:
        """x (count, 3) with (A + damping I) x = right (count, 3); ``blocks`` (b, 9) in the pattern's order, row-major.

        ValueError where the matrix is not positive definite.
        """
        answer = np.empty((self.count, 3))
        answer[self.rank] = right
        _native.cholesky_solve(self._symbolic, blocks, damping, answer, self._work, *self._sizes)
        return answer[self.rank]


def _starts(counts: np.ndarray) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(counts.astype(np.int64))])


def _elimination_order(count: int, pattern: np.ndarray) -> np.ndarray:
    """Nodes in the order of elimination (count,), by SuperLU's multiple minimum degree."""
    values = np.concatenate([np.full(count, 4.0 * len(pattern)), np.ones(2 * len(pattern))])
    rows = np.concatenate([np.arange(count), pattern[:, 0], pattern[:, 1]])
    columns = np.concatenate([np.arange(count), pattern[:, 1], pattern[:, 0]])
    matrix = sp.coo_matrix((values, (rows, columns)), shape=(count, count)).tocsc()
    factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return np.argsort(factors.perm_c)


def _supernodes(
    count: int, pattern: np.ndarray, order: np.ndarray
) -> tuple[list[tuple[int, int, np.ndarray]], np.ndarray]:
    """Supernodes (first, width, rows below), in postorder, and the rank (count,) of every node in that order."""
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    below, parent = _structures(count, rank[pattern])
    children: list[list[int]] = [[] for _ in range(count + 1)]
    for node in range(count - 1, -1, -1):
        children[parent[node]].append(node)
    postorder, stack = [], [(root, False) for root in children[count]]
    while stack:
        node, finished = stack.pop()
        if finished:
            postorder.append(node)
        else:
            stack.append((node, True))
            stack += [(child, False) for child in children[node]]
    place = np.empty(count, np.int64)
    place[postorder] = np.arange(count)
    made: list[tuple[int, int, np.ndarray]] = []
    zeros: list[int] = []
    for position, node in enumerate(postorder):
        first, width, rows = position, 1, np.sort(place[np.fromiter(below[node], np.int64, len(below[node]))])
        empty = 0
        while made and made[-1][0] + made[-1][1] == first and len(made[-1][2]) and made[-1][2][0] < first + width:
            before, columns, kept = made[-1]
            joined = zeros[-1] + empty + columns * (width + len(rows) - len(kept))
            size = (columns + width) * (columns + width + 2 * len(rows)) / 2
            if columns + width > _SMALL and joined > _ZEROS * size:
                break
            made.pop()
            zeros.pop()
            first, width, empty = before, columns + width, joined
        made.append((first, width, rows))
        zeros.append(empty)
    return made, place[rank]


def _structures(count: int, edges: np.ndarray) -> tuple[list[set[int]], list[int]]:
    """For every column of the factor the rows below its diagonal, and its parent in the elimination tree (or count)."""
    below: list[set[int]] = [set() for _ in range(count)]
    for high, low in zip(edges.max(1).tolist(), edges.min(1).tolist(), strict=True):
        if high != low:
            below[low].add(high)
    parent = [count] * count
    for node in range(count):
        if below[node]:
            parent[node] = min(below[node])
            below[parent[node]] |= below[node] - {parent[node]}
    return below, parent
