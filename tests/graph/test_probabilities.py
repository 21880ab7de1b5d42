import numpy as np
import pytest
from toy_graph import random_case

from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.probabilities import (
    Traffic,
    even_probabilities,
    objective,
    optimise_probabilities,
    proxy,
    thresholds,
)


def traffic_of(seed, frames=120, pairs=5):
    capture, links = random_case(seed, frames, pairs)
    graph = build_graph(capture, links)
    return Traffic.of_edges(len(graph.nodes), [(e.source, e.target, len(e.inner_frames())) for e in graph.edges])


def random_probabilities(traffic, seed):
    weights = np.random.default_rng(seed).random(len(traffic.source)) + 0.1
    return weights / np.bincount(traffic.source, weights)[traffic.source]


@pytest.mark.parametrize("seed", range(4))
def test_energy_is_the_papers_on_the_frame_by_frame_chain(seed):
    traffic = traffic_of(seed)
    probabilities = random_probabilities(traffic, seed)
    # The contracted chain with every inner frame a node of its own; inner frames are entered with p and left with 1.
    nodes, inner = traffic.chain.nodes, traffic.inner.astype(int)
    size = nodes + inner.sum()
    matrix, free = np.zeros((size, size)), nodes
    for source, target, p, count in zip(traffic.source, traffic.chain.target, probabilities, inner, strict=True):
        path = [source, *range(free, free + count), target]
        free += count
        for i, (a, b) in enumerate(zip(path, path[1:], strict=False)):
            matrix[a, b] += p if i == 0 else 1.0
    visits = np.linalg.matrix_power((matrix + np.eye(size)) / 2, 2**22)[0]
    choice = len(probabilities) / nodes**2 * np.sum(probabilities**2)
    expected = 0.3 * size * np.sum((visits - 1 / size) ** 2) + 0.7 * choice
    assert objective(traffic, probabilities, 0.3)[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("energy", [objective, proxy])
@pytest.mark.parametrize("seed", range(3))
def test_gradients_are_exact(energy, seed):
    traffic = traffic_of(seed)
    probabilities = random_probabilities(traffic, seed)
    gradient = energy(traffic, probabilities, 0.6)[1]
    for edge, direction in enumerate(np.eye(len(probabilities)) * 1e-5):
        values = [energy(traffic, probabilities + sign * direction, 0.6)[0] for sign in (1, -1)]
        assert gradient[edge] == pytest.approx((values[0] - values[1]) / 2e-5, rel=1e-6, abs=1e-8)


def test_proxy_is_convex():
    traffic = traffic_of(1)
    for seed in range(20):
        a, b = random_probabilities(traffic, seed), random_probabilities(traffic, seed + 100)
        ends = (proxy(traffic, a, 0.5)[0] + proxy(traffic, b, 0.5)[0]) / 2
        assert proxy(traffic, (a + b) / 2, 0.5)[0] <= ends


def pattern_search(traffic, start, floor, alpha, evaluations):
    """Moves probability between pairs of a node's out-edges, halving the step where nothing helps."""
    best, step = objective(traffic, start, alpha)[0], 0.2
    p = start.copy()
    pairs = [(a, b) for a in range(len(p)) for b in range(len(p)) if a != b and traffic.source[a] == traffic.source[b]]
    while evaluations > 0 and step > 1e-7:
        improved = False
        for a, b in pairs:
            amount = min(step, p[b] - floor[b])
            if amount > 0:
                trial = p.copy()
                trial[a] += amount
                trial[b] -= amount
                evaluations -= 1
                value = objective(traffic, trial, alpha)[0]
                if value < best:
                    best, p, improved = value, trial, True
        if not improved:
            step /= 2
    return best


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("alpha", "least_share"), [(0.08, 0.1), (0.9, 0.02)])
def test_no_pattern_search_does_better(seed, alpha, least_share):
    traffic = traffic_of(seed)
    options = GraphOptions(alpha=alpha, least_share=least_share)
    even = even_probabilities(traffic)
    p = optimise_probabilities(traffic, options)
    assert np.all(p >= least_share * even * (1 - 1e-12))
    np.testing.assert_allclose(np.bincount(traffic.source, p), 1, atol=1e-12)
    value = objective(traffic, p, alpha)[0]
    assert value <= objective(traffic, even, alpha)[0]
    for start in (even, random_probabilities(traffic, seed) * (1 - least_share) + least_share * even):
        assert value <= pattern_search(traffic, start, least_share * even, alpha, 1500) + 1e-8
    assert value <= pattern_search(traffic, p, least_share * even, alpha, 300) + 1e-8


def test_only_even_choices_are_left_where_the_floor_is_even():
    traffic = traffic_of(0)
    np.testing.assert_array_equal(
        optimise_probabilities(traffic, GraphOptions(least_share=1.0)), even_probabilities(traffic)
    )


def test_thresholds_give_each_edge_its_share_of_the_numbers():
    source = np.array([0, 0, 0, 1, 2, 2])
    limits = thresholds(source, np.array([0.25, 0.5, 0.25, 1.0, 1e-12, 1 - 1e-12]))
    assert limits.dtype == np.uint32
    assert limits.tolist() == [2**30 - 1, 3 * 2**30 - 1, 2**32 - 1, 2**32 - 1, 0, 2**32 - 1]


@pytest.mark.parametrize("seed", range(4))
def test_thresholds_round_to_one_number(seed):
    traffic = traffic_of(seed)
    probabilities = random_probabilities(traffic, seed)
    limits = thresholds(traffic.source, probabilities).astype(np.int64)
    for node in range(traffic.chain.nodes):
        mine = traffic.source == node
        counts = np.diff(np.concatenate([[-1], limits[mine]]))
        assert counts.sum() == 2**32
        np.testing.assert_allclose(counts / 2**32, probabilities[mine], atol=2**-32)
