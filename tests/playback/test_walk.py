import json
import re
from pathlib import Path

import numpy as np
import pytest
from moving_toy import K, moving_capture, moving_links
from toy_capture import toy_capture
from toy_graph import frame_successors, placed_case, random_case

from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.files import graph_from_json, graph_to_json
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.places import Places
from unstructured_mg.graph.request import PathRequest
from unstructured_mg.playback.random_generator import RandomGenerator
from unstructured_mg.playback.walk import path_walk, random_walk


def name(frame):
    return frame.frame if frame.transition is None else (*frame.transition, frame.step)


@pytest.mark.parametrize("seed", range(4))
def test_a_walk_only_takes_ways_of_the_graph(seed):
    capture, links = random_case(seed, 120, 5)
    graph = build_graph(capture, links)
    after = frame_successors(capture.runs(), links)
    names = [name(frame) for frame in random_walk(graph, capture, 2000, seed)]
    assert len(names) == 2000 and names[0] == graph.frames[0]
    assert all(b in after[a] for a, b in zip(names, names[1:], strict=False))
    assert {x for x in names if isinstance(x, int)} == set(graph.frames.tolist())


@pytest.mark.parametrize("seed", [0, 5])
def test_choices_are_those_of_the_description(seed):
    """A player written frame by frame from docs/files.md: a number is drawn only where there is a choice."""
    capture, links = random_case(2, 120, 5)
    graph = build_graph(capture, links)
    generator, ways, names = RandomGenerator(seed), graph.out_edges(), [int(graph.nodes[3])]
    node = 3
    while len(names) < 500:
        edge = ways[node][0]
        if len(ways[node]) > 1:
            drawn = generator.draw()
            edge = min(e for e in ways[node] if drawn <= int(graph.thresholds[e]))
        for segment in graph.edges[edge].segments:
            link = None if segment.link is None else graph.links[segment.link]
            for i in range(segment.first, segment.last + 1):
                names.append(i if link is None else (link.source, link.target, i))
        node = graph.edges[edge].target
    walk = random_walk(graph, capture, 500, seed, start=int(graph.nodes[3]))
    assert [name(frame) for frame in walk] == names[:500]


def test_a_walk_is_the_same_for_the_same_seed_and_prefix():
    capture, links = random_case(1)
    graph = build_graph(capture, links)
    walk = random_walk(graph, capture, 600, 9)
    assert random_walk(graph, capture, 600, 9) == walk
    assert random_walk(graph, capture, 200, 9).frames == walk.frames[:200]
    assert random_walk(graph, capture, 600, 10).frames != walk.frames


def test_a_transition_plays_between_the_frames_that_it_joins():
    capture = toy_capture(100)
    graph = build_graph(capture, [Link(80, 10, 5, PlanarRigid(0.3, 1, 2), 0.0)])
    walk = random_walk(graph, capture, 80, 0, start=73)
    steps = [(80, 10, step) for step in range(-4, 5)]
    assert [name(frame) for frame in walk] == [73, 74, 75, *steps, *range(15, 76), *steps][:80]
    # The world changes where the transition ends, and not before.
    assert all(frame.world == PlanarRigid() for frame in walk.frames[:12])
    assert all(frame.world == PlanarRigid(0.3, 1, 2) for frame in walk.frames[12:])


@pytest.mark.parametrize("seed", range(3))
def test_world_is_the_product_of_the_transitions_so_far(seed):
    capture, links = random_case(seed)
    graph = build_graph(capture, links)
    motion = {(link.source, link.target): link.alignment.matrix() for link in links}
    expected, frames = np.eye(4), random_walk(graph, capture, 400, seed).frames
    for before, frame in zip((None, *frames), frames, strict=False):
        if before is not None and before.transition is not None and frame.transition is None:
            expected = expected @ motion[before.transition]
        np.testing.assert_allclose(frame.world.matrix(), expected, atol=1e-9)
        assert abs(frame.world.yaw) <= np.pi


def test_a_walk_may_start_inside_an_edge():
    capture, links = random_case(1)
    graph = build_graph(capture, links)
    inside = next(edge.inner_frames()[1] for edge in graph.edges if len(edge.inner_frames()) > 2)
    assert [name(f) for f in random_walk(graph, capture, 2, 0, start=inside)] == [inside, inside + 1]


def test_without_a_loop_the_longest_run_is_played_and_the_end_is_told():
    capture = toy_capture(4, 6, 6)
    walk = random_walk(build_graph(capture, []), capture, 100, 0)
    assert [name(frame) for frame in walk] == list(range(4, 10))
    assert walk.ended == f"The walk ends after 6 frames at frame {capture.frame_id(9)}, where the graph has no way on."
    assert random_walk(build_graph(capture, []), capture, 6, 0).ended is None


def test_a_path_shows_both_its_ends():
    capture = moving_capture(100)
    graph = build_graph(capture, moving_links((20, 68)))
    steps = [(68, 20, step) for step in range(-K + 1, K)]
    assert graph.frames[0] == 20 + K and graph.frames[-1] == 68 - K
    with pytest.raises(UserError, match="Frame 71 is not in the motion graph"):
        path_walk(graph, capture, PathRequest(70, 25))
    walk = path_walk(graph, capture, PathRequest(60, 25))
    assert [name(frame) for frame in walk] == [*range(60, 66), *steps, *range(23, 26)]
    assert [name(frame) for frame in path_walk(graph, capture, PathRequest(40, 40))] == [40]


def test_a_loop_shows_its_first_frame_once_and_says_where_it_goes_on():
    capture = moving_capture(100)
    graph = build_graph(capture, moving_links((20, 68)))
    walk = path_walk(graph, capture, PathRequest(40, loop=True))
    assert (walk.kind, walk.start, walk.goal) == ("loop", 40, None)
    names = [name(frame) for frame in walk]
    assert names[0] == 40 and names[-1] == 39 and len(set(names)) == len(names)
    alignment = graph.links[next(i for i, link in enumerate(graph.links) if link.source == 68)].alignment
    assert walk.frames[-1].world == walk.again
    np.testing.assert_allclose(walk.again.matrix(), alignment.matrix(), atol=1e-12)


def test_a_path_along_a_curve_begins_on_it():
    capture, graph = placed_case(0, 60, 2, k=2)
    curve = np.array([[3.0, 1.0], [3.0, 2.0]])
    walk = path_walk(graph, capture, PathRequest(curve=curve))
    assert walk.kind == "path" and "strays" in walk.remark
    first = walk.frames[0].world.apply(np.array([*graph.places.captured[walk.start], 0.0]))
    assert np.linalg.norm(first[:2] - curve[0]) < 0.5


def test_what_cannot_be_walked_is_said_in_a_sentence():
    capture, links = random_case(0)
    graph = build_graph(capture, links)
    outside = next(i for i in range(len(capture)) if i not in graph.frames)
    for frames, seed, start, said in (
        (0, 0, None, "A walk of 0 frames"),
        (5, -1, None, "Seed -1 is out of range"),
        (5, 2**32, None, "choose a whole number from 0 to 4294967295"),
        (5, 0, outside, f"Frame {capture.frame_id(outside)} is not in the motion graph"),
    ):
        with pytest.raises(UserError, match=said):
            random_walk(graph, capture, frames, seed, start)


def test_the_pages_sample_graph_is_walked_as_the_page_says():
    page = (Path(__file__).parents[2] / "docs" / "files.md").read_text()
    sample = json.loads(re.search(r"^## graph.json$.*?^```json\n(.*?)^```$", page, re.M | re.S)[1])
    capture = toy_capture(12)
    links = [Link(9, 3, 1, PlanarRigid(0.5, 1.0, -2.0), 0.2), Link(7, 3, 1, PlanarRigid(-0.25, 0.0, 0.5), 0.4)]
    graph = graph_from_json(sample, capture)
    down = np.column_stack([np.zeros(12), -0.1 * np.arange(12)])
    places = Places(down, (down[[9]], down[[7]]))
    built = graph_to_json(
        build_graph(capture, links, places=places), capture, {(9, 3): {"seam_jump": 0.8}, (7, 3): {"seam_jump": 1.1}}
    )
    for key, value in built.items():
        if key in ("visits", "edges", "transitions"):
            continue  # numbers in these are rounded on the page
        assert sample[key] == value, key
    assert [t["places"] for t in sample["transitions"]] == [t["places"] for t in built["transitions"]]
    assert graph.links == tuple(sorted(links, key=lambda link: link.source))
    np.testing.assert_allclose(graph.visits, built["visits"], atol=1e-4)
    for edge, entry in zip(built["edges"], sample["edges"], strict=True):
        assert edge == {**entry, "probability": pytest.approx(entry["probability"], abs=1e-4),
                        "threshold": pytest.approx(entry["threshold"], abs=1e4)}  # fmt: skip
    table = re.findall(r"^\| (\d+) \| (5 6 7 .*) \|$", page, re.M)
    assert len(table) == 3
    for seed, frames in table:
        walk = random_walk(graph, capture, 24, int(seed))
        shown = [
            capture.frame_id(f.frame) if f.transition is None else ">".join(capture.frame_id(i) for i in f.transition)
            for f in walk
        ]
        assert shown == frames.split()
