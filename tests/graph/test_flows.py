import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize
from toy_graph import random_case

from unstructured_mg.graph.flows import entropy_rate, flow_energy, optimise_flows
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.probabilities import Traffic, even_probabilities


def traffic_of(seed, frames=120, pairs=5, uneven=False):
    graph = build_graph(*random_case(seed, frames, pairs))
    edges = [(e.source, e.target, len(e.inner_frames())) for e in graph.edges]
    plain = Traffic.of_edges(len(graph.nodes), edges)
    if not uneven:
        return plain
    random = np.random.default_rng(seed)
    pulls = (
        plain.node_pull * random.uniform(0.5, 2, len(graph.nodes)),
        plain.edge_pull * random.uniform(0.5, 2, len(edges)),
    )
    return Traffic.of_edges(len(graph.nodes), edges, pulls)


def flows_of(traffic, probabilities):
    return traffic.visits(probabilities)[1]


@pytest.mark.parametrize("seed", range(3))
def test_gradient_and_hessian_are_exact(seed):
    traffic = traffic_of(seed, uneven=True)
    flows = np.random.default_rng(seed).uniform(0.01, 0.03, len(traffic.source))
    _, gradient, hessian = flow_energy(traffic, flows, 0.3, 0.7)
    for edge, move in enumerate(np.eye(len(flows)) * 1e-6):
        up, down = (flow_energy(traffic, flows + sign * move, 0.3, 0.7) for sign in (1, -1))
        assert gradient[edge] == pytest.approx((up[0] - down[0]) / 2e-6, rel=1e-5, abs=1e-6)
        np.testing.assert_allclose(hessian[edge], (up[1] - down[1]) / 2e-6, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("alpha", "least_share"), [(0.0, 0.1), (0.3, 0.0), (0.9, 0.3)])
def test_a_general_solver_finds_nothing_better(seed, alpha, least_share):
    traffic = traffic_of(seed, uneven=seed > 1)
    ours = optimise_flows(traffic, GraphOptions(alpha=alpha, least_share=least_share))
    even = even_probabilities(traffic)
    entropy = entropy_rate(traffic, even)
    assert np.all(ours >= least_share * even * (1 - 1e-9))
    np.testing.assert_allclose(np.bincount(traffic.source, ours), 1, atol=1e-12)
    source, target, count = traffic.source, traffic.chain.target, len(ours)
    equal = [(source == node).astype(float) - (target == node) for node in range(1, traffic.chain.nodes)]
    floors = np.eye(count) - least_share * even[:, None] * (source[:, None] == source)
    start = flows_of(traffic, even)
    found = minimize(
        lambda x: flow_energy(traffic, x, alpha, entropy)[:2],
        start,
        jac=True,
        method="trust-constr",
        constraints=[
            LinearConstraint(np.array([*equal, 1 + traffic.inner]), [0] * len(equal) + [1], [0] * len(equal) + [1]),
            LinearConstraint(floors, 0, np.inf, keep_feasible=True),
        ],
        bounds=[(1e-12, None)] * count,
        options={"maxiter": 300, "gtol": 1e-9, "xtol": 1e-12},
    )
    assert flow_energy(traffic, flows_of(traffic, ours), alpha, entropy)[0] <= found.fun + 1e-6


def test_of_all_walks_that_of_most_entropy_is_parrys():
    """With nothing else asked for and every edge one captured frame long, the maximum is known in closed form."""
    edges = [(0, 1, 0), (0, 2, 0), (1, 0, 0), (1, 2, 0), (2, 0, 0), (0, 0, 0)]
    traffic = Traffic.of_edges(3, edges)
    found = optimise_flows(traffic, GraphOptions(alpha=0.0, least_share=0.0))
    matrix = np.zeros((3, 3))
    for a, b, _ in edges:
        matrix[a, b] = 1
    values, vectors = np.linalg.eig(matrix)
    best = int(np.argmax(values.real))
    largest, right = values[best].real, np.abs(vectors[:, best].real)
    expected = [right[b] / (largest * right[a]) for a, b, _ in edges]
    np.testing.assert_allclose(found, expected, atol=1e-4)
    assert entropy_rate(traffic, found) == pytest.approx(np.log(largest), abs=1e-8)


def test_only_even_choices_are_left_where_the_floor_is_even():
    traffic = traffic_of(0)
    np.testing.assert_array_equal(optimise_flows(traffic, GraphOptions(least_share=1.0)), even_probabilities(traffic))
