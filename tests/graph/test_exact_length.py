import numpy as np
import pytest
from toy_graph import least_costs, placed_case, played_names

from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.routes import build_routes


@pytest.mark.parametrize("seed", range(4))
def test_costs_of_every_length_are_those_of_the_frames_and_the_path_has_them(seed):
    capture, graph = placed_case(seed, 60, 3, k=2)
    random = np.random.default_rng(seed)
    for start, goal in random.choice(graph.frames, (4, 2)).tolist():
        routes = build_routes(graph, capture, start, goal)
        table = LengthTable(routes)
        expected = least_costs(graph, capture, start, goal, 150)
        np.testing.assert_allclose(table.upto(150)[:, routes.start], expected)
        for frames in np.flatnonzero(np.isfinite(expected)).tolist():
            arcs = table.trace(routes.start, frames)
            path = routes.path(arcs)
            assert len(path) == frames and (path.start, path.goal) == (start, goal)
            assert sum(routes.arcs[a].cost for a in arcs) == pytest.approx(expected[frames])
            assert frames == 0 or played_names(graph, path.segments)[-1] == goal


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_possible_length_is_found(seed):
    capture, graph = placed_case(seed, 60, 2, k=2)
    start, goal = int(graph.frames[-1]), int(graph.frames[0])
    expected = least_costs(graph, capture, start, goal, 400)
    possible = np.flatnonzero(np.isfinite(expected))
    routes = build_routes(graph, capture, start, goal)
    for wanted in range(200):
        assert LengthTable(routes).possible(routes.start, wanted) == possible[np.argmin(np.abs(possible - wanted))]
    assert LengthTable(routes).possible(routes.start, 0, 60) == possible[possible >= 60][0]


def test_rows_are_the_same_in_whatever_order_they_are_asked_for():
    capture, graph = placed_case(2)
    routes = build_routes(graph, capture, int(graph.frames[0]), int(graph.frames[-1]))
    once, often = LengthTable(routes), LengthTable(routes)
    for frames in (0, 3, 50, 20, 51, 200):
        often.upto(frames)
    np.testing.assert_array_equal(often.upto(200), once.upto(200))


def test_a_goal_behind_is_impossible_and_a_path_without_a_goal_may_stop_anywhere():
    capture, graph = placed_case(0, 40, 0)
    assert not graph.cyclic
    behind = build_routes(graph, capture, 20, 3)
    assert LengthTable(behind).possible(behind.start, 10) is None
    anywhere = build_routes(graph, capture, 20, None)
    assert np.isfinite(LengthTable(anywhere).upto(19)[19, anywhere.start])
    with pytest.raises(ValueError, match="frames"):
        LengthTable(behind).trace(behind.start, 10)
