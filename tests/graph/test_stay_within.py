import numpy as np
import pytest
from toy_graph import placed_case

from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.floor_track import floor_track
from unstructured_mg.graph.routes import build_routes
from unstructured_mg.graph.stay_within import stay_within


def every_path(routes, frames):
    """All arc sequences that play ``frames`` frames: to the goal exactly, without one as many as are needed."""
    waiting, found = [((), routes.start, 0)], []
    while waiting:
        arcs, node, time = waiting.pop()
        if (time == frames and node == routes.goal) or (time >= frames and routes.goal is None):
            found.append(arcs)
        if time < frames:
            waiting += [((*arcs, i), routes.arcs[i].target, time + routes.arcs[i].frames) for i in routes.out[node]]
    return found


def measured(routes, arcs, frames):
    """(how far it gets away, cost) of a path."""
    graph = routes.graph
    points, _ = floor_track(graph.places, graph.links, [s for a in arcs for s in routes.arcs[a].segments])
    away = np.linalg.norm(points[:frames] - graph.places.captured[routes.frames[routes.start]], axis=1)
    return away.max(), sum(routes.arcs[a].cost for a in arcs)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("to", ["anywhere", "back", "there"])
def test_no_path_of_the_length_stays_nearer_or_costs_less(seed, to):
    capture, graph = placed_case(seed, 70, 3, k=2)
    start = int(graph.frames[3])
    goal = {"anywhere": None, "back": start, "there": int(graph.frames[-2])}[to]
    routes = build_routes(graph, capture, start, goal)
    frames = LengthTable(routes).possible(routes.start, 90, 1) if goal is not None else 60
    paths = [measured(routes, arcs, frames) for arcs in every_path(routes, frames)]
    assert paths
    radii = [radius for radius, _ in paths]
    for radius in (0.0, float(np.median(radii)), max(radii) + 1):
        found = stay_within(routes, frames, radius, width=5000)
        outside, cost = min((max(r - radius, 0), c) for r, c in paths)
        assert max(found.radius - radius, 0) == pytest.approx(outside, abs=1e-9)
        assert found.cost == pytest.approx(cost, abs=1e-9)
        assert measured(routes, found.arcs, frames) == (pytest.approx(found.radius), pytest.approx(found.cost))


def test_a_narrow_search_still_ends_in_time():
    capture, graph = placed_case(1, 90, 6, k=2)
    routes = build_routes(graph, capture, int(graph.frames[0]), int(graph.frames[0]))
    frames = LengthTable(routes).possible(routes.start, 400, 1)
    path = routes.path(stay_within(routes, frames, 0.5, width=4).arcs, frames)
    assert len(path) == frames and path.goal == path.start


def test_impossible_lengths_and_graphs_without_places():
    capture, graph = placed_case(0, 40, 0)
    assert stay_within(build_routes(graph, capture, 3, 20), 5, 1.0) is None
    assert stay_within(build_routes(graph, capture, 3, 3), 0, 1.0).arcs == ()
