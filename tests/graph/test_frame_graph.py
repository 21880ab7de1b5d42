from collections import Counter

import numpy as np
import pytest
from toy_capture import toy_capture
from toy_graph import frame_successors, random_case

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.frame_graph import build_frame_graph, largest_loop
from unstructured_mg.graph.link import Link


def link(source, target, k=2):
    return Link(source, target, k, PlanarRigid(), 0.0)


def names(graph, links):
    """Node number to the name that ``frame_successors`` uses."""
    steps = [(w.source, w.target, step) for w in links for step in w.steps]
    return [*range(graph.captured), *steps]


@pytest.mark.parametrize("seed", range(5))
def test_edges_are_those_of_the_definition(seed):
    capture, links = random_case(seed)
    graph = build_frame_graph(len(capture), capture.runs(), links)
    name = names(graph, links)
    edges = Counter((name[s], name[t]) for s, t in zip(graph.source, graph.target, strict=True))
    after = frame_successors(capture.runs(), links)
    assert edges == Counter((a, b) for a, bs in after.items() for b in bs)


def reached_from(after, start):
    seen, waiting = {start}, [start]
    while waiting:
        for b in after[waiting.pop()]:
            if b not in seen:
                seen.add(b)
                waiting.append(b)
    return seen


@pytest.mark.parametrize("seed", range(8))
def test_largest_loop_is_the_largest_set_of_frames_that_all_reach_each_other(seed):
    capture, links = random_case(seed, frames=60, pairs=2)
    graph = build_frame_graph(len(capture), capture.runs(), links)
    after = frame_successors(capture.runs(), links)
    reach = {a: reached_from(after, a) for a in after}
    parts = {frozenset(b for b in reach[a] if a in reach[b]) for a in after}
    parts = [p for p in parts if len(p) > 1]
    captured = [sorted(x for x in p if isinstance(x, int)) for p in parts]
    best = max(range(len(parts)), key=lambda i: (len(captured[i]), -captured[i][0]))
    name = names(graph, links)
    assert {name[i] for i in np.flatnonzero(largest_loop(graph))} == parts[best]


def test_equal_loops_go_to_the_earlier_one():
    capture = toy_capture(30, 30)
    links = [link(50, 40), link(20, 10)]
    loop = largest_loop(build_frame_graph(60, capture.runs(), links))
    assert np.flatnonzero(loop[:60]).tolist() == list(range(12, 19))


def test_no_way_back_is_no_loop():
    capture = toy_capture(30, 30)
    assert largest_loop(build_frame_graph(60, capture.runs(), [])) is None
    assert largest_loop(build_frame_graph(60, capture.runs(), [link(10, 40), link(10, 20)])) is None
    assert largest_loop(build_frame_graph(0, [], [])) is None


def test_a_link_back_to_its_own_frame_is_a_loop():
    graph = build_frame_graph(30, [range(30)], [link(14, 10)])
    assert np.flatnonzero(largest_loop(graph)).tolist() == [12, 30, 31, 32]


@pytest.mark.parametrize(
    ("links", "named"),
    [
        ([link(1, 20)], r"links\[0\].source: expected frames -1 to 3"),
        ([link(10, 20), link(10, 31)], r"links\[1\].target: expected frames 29 to 33"),
        ([link(10, 58)], r"links\[0\].target: expected frames 56 to 60"),
        ([link(10, 20, k=0)], r"links\[0\].k: expected 1 or more, got 0"),
        ([link(10, 20), link(10, 20)], r"links\[1\]: expected one link from 10 to 20"),
    ],
)
def test_links_that_do_not_fit_are_named(links, named):
    with pytest.raises(ValueError, match=named):
        build_frame_graph(60, [range(30), range(30, 60)], links)
