import numpy as np
import pytest
from toy_graph import placed_case

from unstructured_mg.graph import distance_time
from unstructured_mg.graph.distance_time import HASTE, solve_distance_time
from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.routes import build_routes


def best_by_listing(routes, distance, frames, most, closed=False):
    """Least objective over all paths of up to ``most`` frames, kept apart by node, time and distance (to a nanometre).

    Independent of the programme: paths are grown arc by arc."""
    best = np.inf
    grown = {0: {(routes.start, 0.0): 0.0}}
    for time in range(most + 1):
        for (node, walked), cost in grown.pop(time, {}).items():
            if node == routes.goal and not (closed and time == 0):
                best = min(best, cost + abs(walked - distance) / 0.3 + abs(time - frames) / 10)
            for index in routes.out[node]:
                arc = routes.arcs[index]
                key = (arc.target, round(walked + arc.distance, 9))
                later = grown.setdefault(time + arc.frames, {})
                later[key] = min(later.get(key, np.inf), cost + arc.cost)
    return best


@pytest.mark.parametrize("seed", range(6))
def test_no_listed_path_is_better(seed):
    capture, graph = placed_case(seed, 60, 2, k=3)
    start, goal = int(graph.frames[0]), int(graph.frames[-1])
    routes = build_routes(graph, capture, start, goal)
    for distance, frames in ((2.0, 40), (0.5, 100), (6.0, 120)):
        found = solve_distance_time(routes, distance, frames)
        assert found.objective == pytest.approx(best_by_listing(routes, distance, frames, 170), abs=1e-7)
        path = routes.path(found.arcs)
        assert (path.start, path.goal, len(path)) == (start, goal, found.frames)
        walked = sum(routes.arcs[a].distance for a in found.arcs)
        cost = sum(routes.arcs[a].cost for a in found.arcs)
        assert found.distance == pytest.approx(walked)
        assert found.objective == pytest.approx(
            cost + abs(walked - distance) / 0.3 + abs(found.frames - frames) / 10, abs=1e-7
        )
        for a, b in zip(found.arcs, found.arcs[1:], strict=False):
            assert routes.arcs[a].target == routes.arcs[b].source


def test_the_least_cost_of_a_length_is_that_of_dynamic_programming_though_cheap_loops_lie_apart(monkeypatch):
    cuts = []
    real = distance_time._cuts
    monkeypatch.setattr(distance_time, "_cuts", lambda *given: cuts.append(real(*given)) or cuts[-1])
    for seed in range(12):
        capture, graph = placed_case(seed, 80, 4, k=2)
        routes = build_routes(graph, capture, int(graph.frames[2]), int(graph.frames[6]))
        table = LengthTable(routes)
        frames = table.possible(routes.start, 120)
        found = solve_distance_time(routes, None, frames, exact_frames=True)
        assert found.frames == frames
        assert found.objective == pytest.approx(table.upto(frames)[frames, routes.start], abs=1e-9)
    assert sum(map(len, cuts)) >= 3


@pytest.mark.parametrize("seed", range(3))
def test_a_closed_path_goes_somewhere(seed):
    capture, graph = placed_case(seed, 60, 2, k=2)
    start = int(graph.frames[4])
    routes = build_routes(graph, capture, start, start)
    found = solve_distance_time(routes, 0.0, 0, closed=True)
    assert found.frames > 0 and routes.path(found.arcs).goal == start
    assert found.objective == pytest.approx(best_by_listing(routes, 0.0, 0, 150, closed=True), abs=1e-7)
    assert solve_distance_time(routes, 0.0, 0).arcs == ()


def test_without_a_time_the_shorter_is_taken():
    capture, graph = placed_case(0, 60, 2, k=2)
    routes = build_routes(graph, capture, int(graph.frames[0]), int(graph.frames[-1]))
    found = solve_distance_time(routes, 3.0, None)
    cost = sum(routes.arcs[a].cost for a in found.arcs)
    assert found.objective == pytest.approx(cost + abs(found.distance - 3.0) / 0.3 + HASTE * found.frames, abs=1e-7)


def test_where_no_way_leads_there_is_none():
    capture, graph = placed_case(0, 40, 0)
    assert solve_distance_time(build_routes(graph, capture, 20, 3), 1.0, 10) is None
    routes = build_routes(graph, capture, 3, 20)
    assert solve_distance_time(routes, 1.0, 500).frames == 17
    with pytest.raises(ValueError, match="goal"):
        solve_distance_time(build_routes(graph, capture, 3, None), 1.0, 10)
    with pytest.raises(ValueError, match="frames"):
        solve_distance_time(routes, 1.0, None, exact_frames=True)
