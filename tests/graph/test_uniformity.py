import numpy as np
import pytest
from scipy.optimize import linprog
from toy_capture import toy_capture
from toy_graph import frame_successors, random_case

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.uniformity import obstacle_sentence


def captured_ways(graph, capture):
    after = frame_successors(capture.runs(), list(graph.links))
    inside = set(graph.frames.tolist())
    used = {(graph.links[i].source, graph.links[i].target) for i in graph.links_used()}
    ways = []
    for a in graph.frames.tolist():
        for b in after[a]:
            if isinstance(b, tuple):
                b = b[1] + next(w.k for w in graph.links if (w.source, w.target) == b[:2]) if b[:2] in used else None
            if b in inside:
                ways.append((a, b))
    return ways


@pytest.mark.parametrize("seed", range(12))
def test_obstacles_are_found_exactly_where_no_uniform_flow_exists(seed):
    capture, links = random_case(seed, 40, 1 + seed % 4, k=2)
    graph = build_graph(capture, links)
    ways, frames = captured_ways(graph, capture), graph.frames.tolist()
    balance = np.zeros((2 * len(frames), len(ways)))
    for column, (a, b) in enumerate(ways):
        balance[frames.index(a), column] = balance[len(frames) + frames.index(b), column] = 1
    feasible = linprog(np.zeros(len(ways)), A_eq=balance, b_eq=np.ones(2 * len(frames))).status == 0
    assert (graph.obstacles == ()) == feasible


@pytest.mark.parametrize("seed", range(8))
def test_each_obstacle_is_true(seed):
    capture, links = random_case(seed, 120, 6)
    graph = build_graph(capture, links)
    ways = captured_ways(graph, capture)
    for obstacle in graph.obstacles:
        near, far = (0, 1) if obstacle.leads_to else (1, 0)
        assert {way[far] for way in ways if way[near] in obstacle.crowd} == set(obstacle.narrow)
        assert len(obstacle.crowd) == len(obstacle.narrow) + 1
        crowded = np.isin(graph.frames, obstacle.crowd)
        narrow = np.isin(graph.frames, obstacle.narrow)
        # The walk itself bears it out, up to the time that it spends inside transitions.
        assert graph.visits[narrow].sum() >= graph.visits[crowded].sum() - 1e-9


def test_the_ends_of_a_loop_are_named():
    # Frames 15..75 loop by 75 -> 15, and 25 -> 55 skips some.
    links = [Link(80, 10, 5, PlanarRigid(), 0.0), Link(30, 50, 5, PlanarRigid(), 0.0)]
    graph = build_graph(toy_capture(100), links)
    assert graph.obstacles == ()  # never skipping is uniform
    # With the way back leading to 20 instead, 15..19 are entered only by a second way back, from 60.
    links = [Link(80, 15, 5, PlanarRigid(), 0.0), Link(65, 10, 5, PlanarRigid(), 0.0)]
    capture = toy_capture(100)
    graph = build_graph(capture, links)
    leads, comes = graph.obstacles
    assert (leads.leads_to, leads.crowd, leads.narrow) == (True, (19, 75), (20,))
    assert (comes.leads_to, comes.crowd, comes.narrow) == (False, (15, 61), (60,))
    assert obstacle_sentence(leads, capture) == (
        "Frames 20 and 76 lead only to frame 21, so it is visited as often as both together."
    )
    assert obstacle_sentence(comes, capture) == (
        "Frames 16 and 62 are reached only from frame 61, so it is visited as often as both together."
    )


@pytest.mark.parametrize("seed", range(10))
def test_with_weights_too_obstacles_are_found_exactly_where_no_such_flow_exists(seed):
    capture, links = random_case(seed, 40, 2 + seed % 3, k=2)
    whole = build_graph(capture, links)
    ways, frames = captured_ways(whole, capture), whole.frames.tolist()
    random = np.random.default_rng(seed)
    balance = np.zeros((2 * len(frames), len(ways)))
    for column, (a, b) in enumerate(ways):
        balance[frames.index(a), column] = balance[len(frames) + frames.index(b), column] = 1
    # Half of the weights are those of a walk, so that they can be met.
    weights = random.uniform(0.5, 2, len(frames))
    if seed % 2:
        position = {int(frame): index for index, frame in enumerate(whole.frames)}
        weights = np.array([whole.visits[position[f]] for f in frames])
    wishes = tuple(f"{capture.frame_id(f)}={w!r}" for f, w in zip(frames, weights.tolist(), strict=True))
    graph = build_graph(capture, links, GraphOptions(visits=wishes))
    wanted = np.tile(weights / weights.sum(), 2)
    missed = linprog(
        np.r_[np.zeros(len(ways)), np.ones(2 * len(wanted))],
        A_eq=np.hstack([balance, np.eye(len(wanted)), -np.eye(len(wanted))]),
        b_eq=wanted,
    ).fun
    assert (graph.obstacles == ()) == (missed < 1e-4)
    for obstacle in graph.obstacles:
        near, far = (0, 1) if obstacle.leads_to else (1, 0)
        assert {way[far] for way in ways if way[near] in obstacle.crowd} == set(obstacle.narrow)
        share = dict(zip(frames, wanted, strict=False))
        excess = sum(share[f] for f in obstacle.crowd) - sum(share[f] for f in obstacle.narrow)
        assert obstacle.excess == pytest.approx(excess, abs=1e-4) and excess > 0


def test_what_is_wanted_in_vain_is_named():
    links = [Link(80, 10, 5, PlanarRigid(), 0.0)]
    capture = toy_capture(100)
    graph = build_graph(capture, links, GraphOptions(visits=("31=3",)))
    sentences = [obstacle_sentence(obstacle, capture) for obstacle in graph.obstacles]
    assert sentences == [
        "Frame 31 leads only to frame 32, of which less is wanted, by 3.2 % of all visits.",
        "Frame 31 is reached only from frame 30, of which less is wanted, by 3.2 % of all visits.",
    ]
