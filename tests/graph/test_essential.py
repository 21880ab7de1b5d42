import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from unstructured_mg.graph.essential import QUANTUM, complete_costs, essential_graph, way_costs

RUNS = [range(0, 20), range(20, 34)]
N = 34


def distances(seed):
    """Poses that wander in the plane, so that some are near each other."""
    walk = np.cumsum(np.random.default_rng(seed).normal(size=(N, 2)), axis=0)
    return np.linalg.norm(walk[:, None] - walk, axis=2).astype(np.float32)


def complete(seed, alpha=0.3):
    return complete_costs(distances(seed), RUNS, alpha, 3, 6)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("alpha", [0.05, 1.0])
def test_all_distances_are_those_of_the_complete_graph_exactly(seed, alpha):
    costs = complete(seed, alpha)
    found = essential_graph(costs, RUNS, alpha)
    step = np.rint(alpha / QUANTUM)
    edges = way_costs(N, RUNS, step, found.leaves, found.arrives, found.cost / QUANTUM)
    off_diagonal = np.where(np.eye(N, dtype=bool), np.inf, costs)
    np.testing.assert_array_equal(dijkstra(edges), dijkstra(off_diagonal))
    np.testing.assert_array_equal(found.distances, dijkstra(off_diagonal) * QUANTUM)
    assert 0 < len(found.leaves) < N * N


@pytest.mark.parametrize("seed", range(3))
def test_no_transition_could_be_left_out(seed):
    costs = complete(seed)
    found = essential_graph(costs, RUNS, 0.3)
    step = np.rint(0.3 / QUANTUM)
    for index in range(len(found.leaves)):
        others = np.arange(len(found.leaves)) != index
        edges = way_costs(N, RUNS, step, found.leaves[others], found.arrives[others], found.cost[others] / QUANTUM)
        longer = dijkstra(edges, indices=found.leaves[index])[found.arrives[index]]
        assert longer * QUANTUM > found.cost[index]


def test_uses_are_counted_over_all_trees():
    costs = complete(1)
    found = essential_graph(costs, RUNS, 0.3)
    edges = way_costs(N, RUNS, np.rint(0.3 / QUANTUM), found.leaves, found.arrives, found.cost / QUANTUM)
    _, before = dijkstra(edges, return_predecessors=True)
    pairs = list(zip(found.leaves.tolist(), found.arrives.tolist(), strict=True))
    counted = dict.fromkeys(pairs, 0)
    for root in range(N):
        for node in range(N):
            while before[root, node] >= 0:
                way = (int(before[root, node]), node)
                if way in counted:
                    counted[way] += 1
                node = way[0]
    assert [counted[pair] for pair in pairs] == found.used.tolist()
    assert found.used.min() >= 1


def test_a_capture_is_played_where_that_is_cheaper():
    costs = complete(0) * QUANTUM
    assert costs[3, 4] == pytest.approx(0.3) and costs[3, 5] == pytest.approx(0.6)
    assert np.all(costs[np.arange(19), np.arange(1, 20)] <= 0.3 + QUANTUM)
    assert np.all(np.diag(costs) == 0)


def test_where_poses_are_all_alike_dear_frames_give_more_transitions():
    """B section 3.3: the graph is the denser, the larger alpha is."""
    few, many = (len(essential_graph(complete(2, a), RUNS, a).leaves) for a in (0.05, 2.0))
    assert few < many


def test_what_nothing_joins_stays_apart():
    apart = distances(0)
    apart[:20, 20:] = apart[20:, :20] = np.nan
    found = essential_graph(complete_costs(apart, RUNS, 0.3, 3, 6), RUNS, 0.3)
    assert np.isinf(found.distances[5, 25]) and np.isfinite(found.distances[15, 3])
