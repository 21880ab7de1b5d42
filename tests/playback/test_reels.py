from itertools import islice

import pytest
from signal_toy import MOTION, signal_capture, signal_links
from toy_graph import random_case

from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.request import PathRequest
from unstructured_mg.playback.reels import KEPT, FixedReel, WalkReel, transition_reel
from unstructured_mg.playback.walk import capture_walk, endless_walk, path_walk


def names(frames):
    return [frame.frame if frame.transition is None else (*frame.transition, frame.step) for frame in frames]


@pytest.fixture(params=range(3))
def case(request):
    capture, links = random_case(request.param, 120, 6)
    return build_graph(capture, links), capture


def test_left_alone_it_is_the_endless_walk(case):
    graph, capture = case
    start = int(graph.frames[0])
    reel = WalkReel(graph, capture, 4, start)
    assert [reel.frame(i) for i in range(2000)] == list(islice(endless_walk(graph, 4, start), 2000))


def test_a_goal_is_reached_by_the_shortest_path_and_the_walk_goes_on_from_there(case):
    graph, capture = case
    start, goal = int(graph.frames[0]), int(graph.frames[len(graph.frames) // 2])
    walk = list(islice(endless_walk(graph, 4, start), 400))
    for index in (0, 37, next(i for i, frame in enumerate(walk) if frame.step == 0)):
        reel = WalkReel(graph, capture, 4, start)
        shown = reel.go_to(index, goal)
        turn = next(i for i in range(index, 400) if walk[i].frame is not None)
        way = list(path_walk(graph, capture, PathRequest(walk[turn].frame, goal)))
        on = list(islice(endless_walk(graph, 4, goal), 100))
        assert shown == turn + len(way) - 1
        expected = [*walk[: turn + 1], *way[1:], *on[1:]]
        frames = [reel.frame(i) for i in range(len(expected))]
        assert names(frames) == names(expected)
        # The world goes on: the walk's so far, then the path's.
        world = walk[turn].world.after(way[-1].world)
        assert frames[shown].world.x == pytest.approx(world.x) and frames[shown].world.y == pytest.approx(world.y)


def test_a_loop_repeats_and_can_be_left(case):
    graph, capture = case
    reel = WalkReel(graph, capture, 4, int(graph.frames[0]))
    reel.loop_from(10)
    frames = names(reel.frame(i) for i in range(2000))
    turn = next(i for i in range(10, 100) if isinstance(frames[i], int))
    period = len(path_walk(graph, capture, PathRequest(frames[turn], loop=True)))
    assert frames[turn::period] == [frames[turn]] * len(frames[turn::period])
    assert frames[turn : turn + period] * 3 == frames[turn : turn + 3 * period]
    reel.wander_from(turn)
    assert names(reel.frame(i) for i in range(turn, turn + 300)) == names(
        islice(endless_walk(graph, 4, frames[turn]), 300)
    )


def test_memory_is_bounded():
    capture, links = random_case(0, 120, 6)
    graph = build_graph(capture, links)
    reel = WalkReel(graph, capture, 1, int(graph.frames[0]))
    last = reel.frame(100_000)
    assert last == next(islice(endless_walk(graph, 1, int(graph.frames[0])), 100_000, None))
    assert len(reel._blocks) <= KEPT and reel.first > 0 and reel.frame(0) is None


def test_what_ends_ends():
    capture = signal_capture(30)
    graph = build_graph(capture, [])
    reel = WalkReel(graph, capture, 1, 20)
    assert names(reel.frame(i) for i in range(10)) == list(range(20, 30))
    assert reel.frame(10) is None and reel.ended
    with pytest.raises(UserError):
        reel.go_to(5, 3)
    assert reel.frame(9) is not None
    fixed = FixedReel(capture_walk(capture).frames)
    assert fixed.known == 30 and fixed.frame(30) is None and fixed.frame(-1) is None


def test_a_transition_lies_between_its_neighbours():
    capture, links = signal_capture(30, 30), signal_links((10, 50))
    graph = build_graph(capture, links)
    reel, seams = transition_reel(graph, capture, 0, 12)
    # The run before begins at 0 and the one after ends at 59: 8 and 7 frames are there.
    expected = [*range(8), *[(10, 50, step) for step in range(-2, 3)], *range(53, 60)]
    assert names(reel.frames) == expected
    assert [expected[seam] for seam in seams] == [7, (10, 50, 2)]
    assert {frame.world for frame in reel.frames[:13]} == {PlanarRigid()}
    assert {frame.world for frame in reel.frames[13:]} == {MOTION}
