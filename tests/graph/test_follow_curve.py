import numpy as np
import pytest
from toy_capture import toy_capture
from toy_graph import placed_case

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.floor_track import floor_track, moved
from unstructured_mg.graph.follow_curve import Curve, follow_curve, still_to_pay
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.places import Places
from unstructured_mg.graph.routes import build_routes

# Clips of 19 frames that go a metre straight on, and a metre in a quarter circle to the left or to the right, in steps
# of one length; every clip's end leads to every clip's beginning.
CLIP, K = 19, 2
# The circle that going left for ever makes: 14 of 18 steps of a metre a round, of which 10 turn.
ROUND = (14 / 18) / (np.pi / 2 * 10 / 18)


def steering():
    capture = toy_capture(CLIP, CLIP, CLIP, clips=True)
    step = 1 / (CLIP - 1)
    places = []
    for turn in (0, np.pi / 2, -np.pi / 2):
        headings = turn * (np.arange(CLIP - 1) + 0.5) / (CLIP - 1)
        places.append(step * np.cumsum([[0, 0], *np.column_stack([np.cos(headings), np.sin(headings)])], axis=0))
    captured = np.concatenate(places)
    links, steps = [], []
    for a in range(3):
        for b in range(3):
            source, target = a * CLIP + CLIP - 1 - K, b * CLIP + K
            leaves, arrives = source - K, target + K
            # The pose with which clip a ends, shifted back by what clip b has gone at the arrival, and on by the steps.
            yaw = (0, np.pi / 2, -np.pi / 2)[a] * (leaves - a * CLIP) / (CLIP - 1)
            yaw -= (0, np.pi / 2, -np.pi / 2)[b] * (arrives - b * CLIP) / (CLIP - 1)
            heading = (0, np.pi / 2, -np.pi / 2)[a] * (leaves - a * CLIP) / (CLIP - 1)
            way = captured[leaves] + 2 * K * step * np.array([np.cos(heading), np.sin(heading)])
            x, y = way - moved(captured[arrives], PlanarRigid(yaw))
            links.append(Link(source, target, K, PlanarRigid(float(yaw), float(x), float(y)), 0.0))
            share = (np.arange(1, 2 * K) / (2 * K))[:, None]
            steps.append((1 - share) * captured[leaves] + share * way)
    return capture, build_graph(capture, links, places=Places(captured, tuple(steps)))


def shown(found):
    graph = found.routes.graph
    path = found.routes.path(found.arcs, found.frames)
    points, _ = floor_track(graph.places, graph.links, path.segments)
    return moved(np.concatenate([graph.places.captured[path.start][None], points]), found.world)


def straying(found, curve):
    points = shown(found)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return np.linalg.norm(points - curve.at(along), axis=1)


@pytest.mark.parametrize(
    "points",
    [
        [[0, 0], [5, 0]],
        [[3, -2], [3, 3], [5, 5]],
        [[ROUND * np.cos(a), ROUND * np.sin(a)] for a in np.linspace(0, 1.9 * np.pi, 60)],
        [[0, 0], [2, 0], [3, 1], [3, 3], [2, 4], [0, 4]],
    ],
)
def test_a_figure_that_can_steer_stays_on_the_curve(points):
    capture, graph = steering()
    curve = Curve.through(np.array(points, float))
    found = follow_curve([build_routes(graph, capture, int(graph.frames[0]), None)], curve, width=100)
    away = straying(found, curve)
    assert found.mean == pytest.approx(away.mean()) and found.largest == pytest.approx(away.max())
    assert found.mean < 0.15
    # As long as the curve, to a frame.
    assert abs(np.linalg.norm(np.diff(shown(found), axis=0), axis=1).sum() - curve.length) < 0.06


def test_a_whole_search_is_no_worse_than_any_path():
    capture, graph = placed_case(3, 60, 2, k=2)
    curve = Curve.through(np.array([[0, 0], [0.8, 0.3], [1.2, 1.1]]))
    routes = build_routes(graph, capture, int(graph.frames[0]), None)
    found = follow_curve([routes], curve)
    waiting, best = [((), routes.start, 0.0)], np.inf
    while waiting:
        arcs, node, along = waiting.pop()
        if along < curve.length:
            waiting += [((*arcs, i), routes.arcs[i].target, along + routes.arcs[i].distance) for i in routes.out[node]]
            continue
        segments = [segment for arc in arcs for segment in routes.arcs[arc].segments]
        points, _ = floor_track(graph.places, graph.links, segments)
        points = np.concatenate([graph.places.captured[routes.frames[routes.start]][None], points])
        steps = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        last = int(np.argmax(steps >= curve.length))
        # The best rigid placing of this path by squares, by singular values.
        path, wanted = points[: last + 1], curve.at(steps[: last + 1])
        u, _, v = np.linalg.svd((path - path.mean(0)).T @ (wanted - wanted.mean(0)))
        turn = v.T @ np.diag([1, np.sign(np.linalg.det(v.T @ u.T))]) @ u.T
        errors = np.linalg.norm((path - path.mean(0)) @ turn.T + wanted.mean(0) - wanted, axis=1)
        best = min(best, errors.mean())
    assert found.mean <= best * 1.1


def test_the_bound_is_what_an_error_that_shrinks_as_fast_as_it_can_adds_up_to():
    assert still_to_pay(np.array([1.0]), np.array([9.0]), 0.1)[0] == pytest.approx(0.8 + 0.6 + 0.4 + 0.2)
    assert still_to_pay(np.array([1.0]), np.array([0.25]), 0.1)[0] == pytest.approx(0.8 + 0.6)
    assert still_to_pay(np.array([1.0]), np.array([9.0]), 0.0)[0] == 0


def test_who_never_moves_follows_nothing():
    capture, graph = steering()
    still = Places(np.zeros_like(graph.places.captured), tuple(np.zeros_like(s) for s in graph.places.steps))
    links = [Link(w.source, w.target, w.k, PlanarRigid(), 0.0) for w in graph.links]
    routes = build_routes(build_graph(capture, links, places=still), capture, int(graph.frames[0]), None)
    assert follow_curve([routes], Curve.through(np.array([[0, 0], [1.0, 0]]))) is None


def test_a_curve_without_a_length_is_an_error():
    with pytest.raises(ValueError, match="points"):
        Curve.through(np.ones((4, 2)))
    assert Curve.through(np.array([[0, 0], [1, 0], [1, 2.0]])).at(np.array([-1, 1.5, 9])).tolist() == [
        [0, 0],
        [1, 0.5],
        [1, 2],
    ]
