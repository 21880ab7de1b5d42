import numpy as np
import pytest

from unstructured_mg.graph.stationary import Chain, stationary_distribution


def random_chain(seed, nodes, extra):
    """A ring, so irreducible, with random chords, loops and parallel edges."""
    random = np.random.default_rng(seed)
    source = np.concatenate([np.arange(nodes), random.integers(0, nodes, extra)])
    target = np.concatenate([np.roll(np.arange(nodes), -1), random.integers(0, nodes, extra)])
    weights = random.random(len(source)) + 0.05
    return source, target, weights / np.bincount(source, weights)[source]


def dense(source, target, probabilities, nodes):
    matrix = np.zeros((nodes, nodes))
    np.add.at(matrix, (source, target), probabilities)
    return matrix


@pytest.mark.parametrize(("nodes", "extra"), [(1, 0), (1, 2), (2, 1), (7, 5), (60, 90)])
def test_it_is_what_power_iteration_reaches(nodes, extra):
    source, target, probabilities = random_chain(nodes, nodes, extra)
    matrix = dense(source, target, probabilities, nodes)
    lazy = np.linalg.matrix_power((matrix + np.eye(nodes)) / 2, 2**20)  # laziness: a periodic chain converges too
    found = stationary_distribution(source, target, probabilities, nodes)
    np.testing.assert_allclose(found, lazy[0], atol=1e-12)
    np.testing.assert_allclose(found @ matrix, found, atol=1e-15)


def test_rare_nodes_keep_their_digits():
    # A birth-death chain: detailed balance gives every probability exactly, down to 1e-90 of the first.
    nodes, up = 31, 1e-3
    source = [0, *np.repeat(np.arange(1, nodes - 1), 2), nodes - 1]
    target = [1, *(node + way for node in range(1, nodes - 1) for way in (1, -1)), nodes - 2]
    probabilities = np.array([1.0, *np.tile([up, 1 - up], nodes - 2), 1.0])
    exact = np.ones(nodes)
    for node in range(1, nodes):
        rise = 1.0 if node == 1 else up
        fall = 1.0 if node == nodes - 1 else 1 - up
        exact[node] = exact[node - 1] * rise / fall
    found = stationary_distribution(np.array(source), np.array(target), probabilities, nodes)
    np.testing.assert_allclose(found, exact / exact.sum(), rtol=1e-12)


def test_adjoint_gives_the_derivative():
    source, target, probabilities = random_chain(3, 12, 20)
    chain, weights = Chain(source, target, 12), np.random.default_rng(4).normal(size=12)
    solved = chain.solve(probabilities)
    derivative = solved.visits[source] * solved.adjoint(weights)[target]
    for edge in range(len(source)):
        step = np.zeros(len(source))
        step[edge] = 1e-6
        values = [weights @ chain.solve(probabilities + sign * step).visits for sign in (1, -1)]
        assert derivative[edge] == pytest.approx((values[0] - values[1]) / 2e-6, rel=1e-6, abs=1e-7)
