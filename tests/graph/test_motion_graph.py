from collections import Counter

import numpy as np
import pytest
from toy_capture import toy_capture
from toy_graph import frame_successors, random_case

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import Segment, build_graph
from unstructured_mg.graph.options import GraphOptions


def played(graph, edge):
    names = []
    for segment in edge.segments:
        link = None if segment.link is None else graph.links[segment.link]
        for i in range(segment.first, segment.last + 1):
            names.append(i if link is None else (link.source, link.target, i))
    return names


def uncontracted(graph):
    edges = []
    for edge in graph.edges:
        path = [int(graph.nodes[edge.source]), *played(graph, edge)]
        assert path[-1] == graph.nodes[edge.target]
        assert len(edge) == len(path) - 1
        assert edge.inner_frames() == [x for x in path[1:-1] if isinstance(x, int)]
        edges += list(zip(path, path[1:], strict=False))
    return Counter(edges)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(("frames", "pairs"), [(60, 2), (200, 12)])
def test_contraction_loses_no_way_and_invents_none(seed, frames, pairs):
    capture, links = random_case(seed, frames, pairs)
    graph = build_graph(capture, links)
    after = frame_successors(capture.runs(), links)
    inside = {*graph.frames.tolist(), *((s, t, i) for s, t, i in (x for x in after if isinstance(x, tuple)))}
    used = {(graph.links[i].source, graph.links[i].target) for i in graph.links_used()}
    inside = {x for x in inside if isinstance(x, int) or x[:2] in used}
    assert uncontracted(graph) == Counter((a, b) for a in inside for b in after[a] if b in inside)
    ways_in = Counter(b for a in inside for b in after[a] if b in inside)
    ways_out = {a: sum(b in inside for b in after[a]) for a in inside}
    meeting = sorted(x for x in inside if (ways_in[x], ways_out[x]) != (1, 1))
    assert graph.nodes.tolist() == (meeting or [graph.frames[0]])


def test_parallel_chains_stay_apart():
    capture = toy_capture(100)
    back = Link(80, 10, 5, PlanarRigid(), 0.0)
    # Two ways from frame 25 to frame 55: by the capture, and by a transition.
    graph = build_graph(capture, [back, Link(30, 50, 5, PlanarRigid(1.0, 2.0, 3.0), 0.0)])
    assert graph.nodes.tolist() == [25, 55]
    ways = [(e.source, e.target, len(e)) for e in graph.edges]
    assert ways == [(0, 1, 30), (0, 1, 10), (1, 0, 75 - 55 + 9 + 25 - 15 + 1)]
    assert graph.edges[1].transform == PlanarRigid(1.0, 2.0, 3.0)
    assert graph.edges[2].segments == (Segment(None, 56, 75), Segment(1, -4, 4), Segment(None, 15, 25))


def test_a_bare_ring_has_one_node():
    graph = build_graph(toy_capture(100), [Link(80, 10, 5, PlanarRigid(0.1, 0.2, 0.3), 0.0)])
    assert graph.cyclic
    assert graph.nodes.tolist() == [15]
    assert graph.edges[0].segments == (Segment(None, 16, 75), Segment(0, -4, 4), Segment(None, 15, 15))
    assert graph.probabilities.tolist() == [1.0]
    np.testing.assert_allclose(graph.visits, 1 / 61, rtol=1e-12)
    assert graph.obstacles == ()


def test_transforms_multiply_along_an_edge():
    # Clip b is entered from a and left to a with no choice in it: one edge plays both transitions.
    first, second = PlanarRigid(0.4, 1.0, 2.0), PlanarRigid(-1.0, 0.3, 0.1)
    links = [
        Link(20, 50, 5, first, 0.0),
        Link(70, 10, 5, second, 0.0),
        Link(30, 8, 5, PlanarRigid(0.5), 0.0),
    ]
    graph = build_graph(toy_capture(40, 40, clips=True), links)
    longest = max(graph.edges, key=lambda edge: len(edge.segments))
    assert [s.link is None for s in longest.segments] == [False, True, False, True]
    np.testing.assert_allclose(longest.transform.matrix(), first.matrix() @ second.matrix(), atol=1e-15)


@pytest.mark.parametrize("links", [[], [Link(10, 50, 5, PlanarRigid(), 0.0)]])
def test_without_a_loop_the_whole_capture_is_kept(links):
    graph = build_graph(toy_capture(30, 40, 1), links)
    assert not graph.cyclic
    assert graph.frames.tolist() == list(range(71))
    assert graph.visits is None and graph.visits_even is None
    assert len(graph.links_used()) == len(links)
    ends = {0, 29, 30, 69, 70} | ({5, 55} if links else set())
    assert set(graph.nodes.tolist()) == ends


def test_order_of_links_does_not_matter():
    capture, links = random_case(3, 200, 8)
    one, other = build_graph(capture, links), build_graph(capture, links[::-1])
    assert one.edges == other.edges and one.links == other.links
    np.testing.assert_array_equal(one.probabilities, other.probabilities)


@pytest.mark.parametrize("seed", range(2))
def test_visits_are_those_of_a_long_random_walk(seed):
    capture, links = random_case(seed, 60, 3)
    graph = build_graph(capture, links, GraphOptions(alpha=0.9))
    random, ways = np.random.default_rng(seed), graph.out_edges()
    counts = dict.fromkeys(graph.frames.tolist(), 0)
    taken, node = np.zeros(len(graph.edges), int), 0
    for draw in random.random(200_000):
        mine = ways[node]
        edge = mine[min(int(np.searchsorted(np.cumsum(graph.probabilities[mine]), draw)), len(mine) - 1)]
        taken[edge] += 1
        node = graph.edges[edge].target
    for edge, count in zip(graph.edges, taken, strict=True):
        for name in played(graph, edge):
            if isinstance(name, int):
                counts[name] += count
    simulated = np.array([counts[f] for f in graph.frames.tolist()]) / sum(counts.values())
    np.testing.assert_allclose(simulated, graph.visits, atol=0.05 / len(graph.frames))
    assert graph.visits.sum() == pytest.approx(1, abs=1e-12)
    assert graph.visits_even.sum() == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_chosen_probabilities_visit_more_evenly(seed):
    graph = build_graph(*random_case(seed, 200, 8))
    assert graph.visits.std() < graph.visits_even.std()
