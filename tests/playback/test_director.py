from itertools import islice

import pytest
from signal_toy import K, signal_capture, signal_links
from toy_capture import toy_capture

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.playback.director import Director
from unstructured_mg.playback.walk import endless_walk

CAPTURE = signal_capture(60)
GRAPH = build_graph(CAPTURE, signal_links((10, 40), (20, 50)))
START = int(GRAPH.frames[0])


@pytest.fixture
def director():
    return Director(GRAPH, CAPTURE, 3)


def walk(seed, count, start=START):
    return list(islice(endless_walk(GRAPH, seed, start), count))


def test_the_frame_is_chosen_from_elapsed_time(director):
    frames, time = walk(3, 200), 0.0
    for seconds in [0.0, 0.01, 0.024, 0.1, 0.2, 1 / 30, 0.001] * 8:
        time += seconds
        assert director.advance(seconds) == frames[int(30 * time + 1e-9)]
    # A window that hung for a minute does not jump by a minute.
    before = director.index
    director.advance(60)
    assert director.index - before <= 8


def test_speed_scales_time_and_pause_stops_it(director):
    director.press("bracketleft")
    for _ in range(20):
        director.advance(0.1)
    assert director.speed == 0.5 and director.index == 30
    director.press("space")
    director.advance(0.2)
    assert director.index == 30 and not director.playing
    director.press("period")
    director.press("comma")
    assert director.index == 30
    for _ in range(9):
        director.press("bracketright")
    assert director.speed == 2.0


def test_a_chosen_frame_is_walked_to(director):
    director.advance(0.2)
    goal = 15
    director.go_to(goal)
    shown_at = director.goal[1]
    for _ in range(3000):
        frame = director.advance(1 / 30)
        if director.index >= shown_at:
            break
    assert frame.frame == goal and director.goal is None
    assert [director.reel.frame(shown_at + i).frame for i in range(3)] == [frame.frame for frame in walk(3, 3, goal)]


def test_a_frame_outside_the_graph_is_refused_with_a_sentence(director):
    outside = next(frame for frame in range(60) if frame not in GRAPH.frames)
    director.go_to(outside)
    assert director.goal is None and "is not in the motion graph" in director.message
    director.press("c")
    director.go_to(outside)
    assert director.shown().frame == outside


def test_seams_are_shown_before_and_after(director):
    director.press("t")
    link = GRAPH.links[director.link]
    shown = []
    for _ in range(5):
        director.press("b")
        shown.append(director.shown())
    assert [frame.frame if frame.step is None else frame.step for frame in shown] == [
        link.leaves, 1 - K, K - 1, link.arrives, link.leaves
    ]  # fmt: skip
    assert not director.playing
    director.press("Escape")
    assert director.mode == "walk" and director.shown().frame == link.leaves


def test_a_transition_is_repeated(director):
    director.press("t")
    period = director.reel.known
    for _ in range(period):
        director.advance(1 / 30 + 1e-9)
    assert director.index == 0 and director.playing


def test_loop_goes_round_until_it_is_switched_off(director):
    director.press("l")
    names = [director.advance(1 / 30 + 1e-9) for _ in range(600)]
    assert director.loop
    frames = [frame.frame for frame in names]
    again = frames.index(frames[0], 1)
    assert frames[:again] == frames[again : 2 * again]
    director.press("l")
    assert not director.loop
    turn = next(i for i in range(director.index, director.index + 20) if director.reel.frame(i).frame is not None)
    on = walk(3, 50, director.reel.frame(turn).frame)
    assert [director.reel.frame(turn + i).frame for i in range(50)] == [frame.frame for frame in on]


def test_another_seed_is_another_walk_and_is_shown(director):
    director.press("n")
    assert director.seed == 4 and "seed 4" in director.status()
    assert [director.reel.frame(i) for i in range(300)] == walk(4, 300)


def test_scrubbing_a_walk_goes_back_through_what_was_shown(director):
    for _ in range(30):
        director.advance(0.1)
        director.status()
    assert director.index == 90
    director.scrub(0.5)
    assert director.index == 45 and not director.playing and director.shown() == walk(3, 46)[-1]
    director.scrub(1)
    assert director.index == 90


def test_the_status_says_frame_time_and_origin(director):
    for _ in range(10):
        director.advance(0.1)
    assert director.status().splitlines() == [
        "Walk with seed 3: frame 31, 0:01.0",
        f"captured frame {CAPTURE.frame_id(walk(3, 31)[-1].frame)} ({walk(3, 31)[-1].frame + 1} of 60)",
    ]
    director.press("c")
    director.go_to(30)
    assert director.status().startswith("Capture: frame 31 of 60, 0:01.0")


def test_without_transitions_the_capture_plays_and_it_is_said():
    capture = signal_capture(8)
    director = Director(build_graph(capture, []), capture)
    assert director.mode == "capture" and "no transitions" in director.message
    assert [director.advance(1 / 30 + 1e-9).frame for _ in range(10)] == [1, 2, 3, 4, 5, 6, 7, 0, 1, 2]
    for key in ("t", "w", "n", "b", "l", "Escape"):
        assert director.press(key)
    assert director.mode == "capture"


def test_a_walk_that_ends_stands_still_at_its_end():
    capture = toy_capture(30, 60)
    director = Director(build_graph(capture, [Link(50, 80, 3, PlanarRigid(), 0.0)]), capture)
    for _ in range(200):
        frame = director.advance(0.1)
    assert not director.playing and frame.frame == 89
    director.press("l")
    assert not director.loop and "cannot be" in director.message or "no" in director.message.lower()
    assert not director.press("F12")
