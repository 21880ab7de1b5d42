import re
from collections import deque

import pytest
from toy_capture import toy_capture
from toy_graph import frame_successors, random_case

from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.paths import Path, shortest_path


def names(graph, path):
    played = []
    for segment in path.segments:
        link = None if segment.link is None else graph.links[segment.link]
        for i in range(segment.first, segment.last + 1):
            played.append(i if link is None else (link.source, link.target, i))
    return played


def breadth_first(after, start):
    distance, waiting = {start: 0}, deque([start])
    while waiting:
        a = waiting.popleft()
        for b in after[a]:
            if b not in distance:
                distance[b] = distance[a] + 1
                waiting.append(b)
    return distance


@pytest.mark.parametrize("seed", range(4))
def test_paths_are_ways_of_the_uncontracted_graph_and_none_is_shorter(seed):
    capture, links = random_case(seed, 50, 3, k=2)
    graph = build_graph(capture, links)
    after = frame_successors(capture.runs(), links)
    for start in graph.frames.tolist():
        distance = breadth_first(after, start)
        for goal in graph.frames.tolist():
            path = shortest_path(graph, start, goal, capture)
            played = names(graph, path)
            assert len(path) == len(played) == distance[goal]
            for a, b in zip([start, *played], played, strict=False):
                assert b in after[a]
            assert not played or played[-1] == goal


def test_cost_can_outweigh_frames():
    capture = toy_capture(100)
    links = [Link(80, 10, 5, PlanarRigid(), 0.1), Link(30, 50, 5, PlanarRigid(), 2.0)]
    graph = build_graph(capture, links)
    assert len(shortest_path(graph, 20, 60, capture)) == 20
    assert len(shortest_path(graph, 20, 60, capture, cost_weight=9.9)) == 20
    assert len(shortest_path(graph, 20, 60, capture, cost_weight=10.1)) == 40


def test_of_equally_long_paths_the_one_with_fewer_transitions_is_taken():
    capture = toy_capture(100)
    links = [Link(80, 10, 5, PlanarRigid(), 0.0), Link(30, 30, 5, PlanarRigid(), 0.0)]  # 25 -> 35 in 10 either way
    graph = build_graph(capture, links)
    assert names(graph, shortest_path(graph, 20, 40, capture)) == list(range(21, 41))


def test_a_path_to_itself_is_empty():
    capture, links = random_case(0)
    graph = build_graph(capture, links)
    frame = int(graph.frames[3])
    assert shortest_path(graph, frame, frame, capture) == Path(frame, frame, ())


def test_frames_outside_and_goals_behind_are_refused_by_name():
    capture = toy_capture(30, 40, clips=True)
    loop = build_graph(capture, [Link(25, 4, 3, PlanarRigid(), 0.0)])
    refusal = "Frame b:2 is not in the motion graph, whose largest strongly connected part holds 16 frames"
    with pytest.raises(UserError, match=f"{refusal}: choose one of a:8 to a:23."):
        shortest_path(loop, 10, 31, capture)
    line = build_graph(capture, [])
    assert len(shortest_path(line, 2, 20, capture)) == 18
    for start, goal in ((20, 2), (2, 40)):
        with pytest.raises(UserError, match=re.escape(f"Frame {capture.frame_id(goal)} cannot be reached from frame ")):
            shortest_path(line, start, goal, capture)
