import numpy as np
import pytest
from toy_graph import frame_successors, placed_case, played_names

from unstructured_mg.errors import UserError
from unstructured_mg.graph.floor_track import track_length
from unstructured_mg.graph.paths import shortest_path
from unstructured_mg.graph.routes import build_routes


@pytest.mark.parametrize("seed", range(3))
def test_arcs_are_ways_of_the_uncontracted_graph_and_know_their_length(seed):
    capture, graph = placed_case(seed)
    after = frame_successors(capture.runs(), list(graph.links))
    random = np.random.default_rng(seed)
    for start, goal in random.choice(graph.frames, (20, 2)).tolist():
        routes = build_routes(graph, capture, start, goal)
        assert (routes.frames[routes.start], routes.frames[routes.goal]) == (start, goal)
        for arc in routes.arcs:
            names = played_names(graph, arc.segments)
            first = int(routes.frames[arc.source])
            assert names[-1] == routes.frames[arc.target] and arc.frames == len(names)
            for a, b in zip([first, *names], names, strict=False):
                assert b in after[a]
            own = graph.places.captured[first]
            assert arc.distance == pytest.approx(track_length(np.concatenate([own[None], arc.points])))
            ends = [name for name in names if isinstance(name, tuple) and name[2] == 2]
            costs = {(link.source, link.target): link.cost for link in graph.links}
            assert arc.cost == pytest.approx(sum(costs[name[:2]] for name in ends))


def test_the_shortest_path_is_among_them():
    capture, graph = placed_case(1)
    start, goal = int(graph.frames[5]), int(graph.frames[-3])
    routes = build_routes(graph, capture, start, goal)
    shortest = shortest_path(graph, start, goal, capture)
    # By relaxing arcs until nothing changes.
    least = np.full(len(routes.frames), np.inf)
    least[routes.start] = 0
    for _ in routes.frames:
        for arc in routes.arcs:
            least[arc.target] = min(least[arc.target], least[arc.source] + arc.frames)
    assert least[routes.goal] == len(shortest)


def test_a_path_can_stop_inside_a_transition():
    capture, graph = placed_case(0)
    routes = build_routes(graph, capture, int(graph.frames[0]), None)
    index = next(i for i, arc in enumerate(routes.arcs) if arc.segments[0].link is not None)
    routes = build_routes(graph, capture, int(routes.frames[routes.arcs[index].source]), None)
    whole, cut = routes.path([index]), routes.path([index], 2)
    assert whole.goal == routes.frames[routes.arcs[index].target] and len(whole) == routes.arcs[index].frames
    assert cut.goal is None and len(cut) == 2
    assert routes.path([]).goal == routes.path([]).start


def test_frames_outside_are_refused_by_name():
    capture, graph = placed_case(0)
    outside = next(i for i in range(len(capture)) if i not in graph.frames)
    for start, goal in ((outside, None), (int(graph.frames[0]), outside)):
        with pytest.raises(UserError, match=f"Frame {capture.frame_id(outside)} is not in the motion graph"):
            build_routes(graph, capture, start, goal)
