import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from unstructured_mg.tracking.block_cholesky import BlockCholesky


def random_pattern(rng, count, links):
    a, b = rng.integers(0, count, links), rng.integers(0, count, links)
    pairs = np.stack([np.maximum(a, b), np.minimum(a, b)], axis=1)
    diagonal = np.repeat(np.arange(count)[:, None], 2, axis=1)
    return np.unique(np.concatenate([pairs, diagonal]), axis=0)


def grid_pattern(size):
    index = np.arange(size**3).reshape(size, size, size)
    links = [
        np.stack([index[1:].ravel(), index[:-1].ravel()], 1),
        np.stack([index[:, 1:].ravel(), index[:, :-1].ravel()], 1),
        np.stack([index[:, :, 1:].ravel(), index[:, :, :-1].ravel()], 1),
        np.stack([index.ravel(), index.ravel()], 1),
    ]
    return np.concatenate(links)


def matrix_of(count, pattern, blocks):
    full = sp.lil_matrix((3 * count, 3 * count))
    for (i, j), block in zip(pattern, blocks.reshape(-1, 3, 3), strict=True):
        full[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] = block
        if i != j:
            full[3 * j : 3 * j + 3, 3 * i : 3 * i + 3] = block.T
    return full.tocsc()


def blocks_for(rng, count, pattern):
    blocks = rng.normal(size=(len(pattern), 3, 3))
    diagonal = pattern[:, 0] == pattern[:, 1]
    blocks[diagonal] += blocks[diagonal].transpose(0, 2, 1)
    weight = np.bincount(pattern.ravel(), minlength=count)
    blocks[diagonal] += 8.0 * weight[pattern[diagonal, 0]][:, None, None] * np.eye(3)
    return blocks.reshape(-1, 9)


@pytest.mark.parametrize(
    ("count", "pattern"),
    [
        (1, np.array([[0, 0]])),
        (40, random_pattern(np.random.default_rng(1), 40, 30)),
        (60, random_pattern(np.random.default_rng(2), 60, 900)),
        (216, grid_pattern(6)),
    ],
    ids=["one node", "forest", "nearly full", "grid"],
)
def test_solves_agree_with_superlu_for_changing_values(count, pattern):
    rng = np.random.default_rng(0)
    solver = BlockCholesky(count, pattern)
    for damping in (0.0, 0.7):
        blocks, right = blocks_for(rng, count, pattern), rng.normal(size=(count, 3))
        matrix = matrix_of(count, pattern, blocks) + damping * sp.eye(3 * count, format="csc")
        expected = spsolve(matrix, right.ravel()).reshape(-1, 3)
        np.testing.assert_allclose(solver.solve(blocks, right, damping), expected, rtol=1e-10, atol=1e-12)


def test_an_indefinite_matrix_is_named():
    pattern = grid_pattern(3)
    blocks = blocks_for(np.random.default_rng(0), 27, pattern)
    with pytest.raises(ValueError, match="positive definite"):
        BlockCholesky(27, pattern).solve(-blocks, np.ones((27, 3)))
