"""The page's player against the program's own: random numbers, walks, ways and files are the same."""

import base64
import json
import math
import re
from importlib.resources import files
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from player_scripts import in_node
from signal_toy import signal_capture, signal_links, signal_transition
from site_reader import read_site_file
from toy_capture import toy_capture
from toy_graph import random_case

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.request import PathRequest
from unstructured_mg.playback.conformance import frame_label
from unstructured_mg.playback.random_generator import RandomGenerator
from unstructured_mg.playback.site import site_to_json
from unstructured_mg.playback.site_frame import frame_file
from unstructured_mg.playback.site_options import SiteOptions
from unstructured_mg.playback.site_transition import transition_file
from unstructured_mg.playback.walk import endless_walk, path_walk, random_walk

READ = """
const name = (graph, item) => item.link === undefined ? graph.ids[item.frame]
  : `${graph.ids[graph.links[item.link].source]}>${graph.ids[graph.links[item.link].target]}:${item.step}`;
const told = (graph, reel, from, to) => {
  const frames = [];
  for (let i = from; i < to; i++) {
    const item = reel.frame(i);
    if (item === null) break;
    frames.push([name(graph, item), item.world.yaw, item.world.x, item.world.y]);
  }
  return frames;
};
const graph = new umg.Graph(data.site);
"""


def site_of(capture, links):
    """What the page is told, for captures whose meshes do not matter."""
    triangle = TexturedMesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    capture = toy_capture(*[len(run) for run in capture.runs()], mesh_of=lambda index: triangle)
    return site_to_json(build_graph(capture, links), capture), build_graph(capture, links), capture


def assert_same(theirs, walk, capture):
    assert [frame[0] for frame in theirs] == [frame_label(frame, capture) for frame in walk]
    ours = np.array([[f.world.yaw, f.world.x, f.world.y] for f in walk])
    off = np.array([frame[1:] for frame in theirs]) - ours
    off[:, 0] = [math.remainder(turn, math.tau) for turn in off[:, 0]]
    assert np.abs(off).max() < 1e-9


def test_random_numbers_are_those_of_the_description():
    seeds = [0, 1, 7, 42, 2**31, 2**32 - 1]
    drawn = in_node(
        """return data.map((seed) => {
          const generator = new umg.RandomGenerator(seed);
          return Array.from({length: 1000}, () => generator.draw());
        })""",
        seeds,
    )
    for seed, numbers in zip(seeds, drawn, strict=True):
        generator = RandomGenerator(seed)
        assert numbers == [generator.draw() for _ in range(1000)]


@pytest.mark.parametrize("case", range(3))
def test_walks_are_those_of_umg_walk_frame_for_frame(case):
    site, graph, capture = site_of(*random_case(case, 120, 6))
    starts = [int(graph.frames[0]), int(graph.frames[len(graph.frames) // 3]), int(graph.nodes[-1])]
    asked = [[seed, start] for seed in (0, 9, 2**32 - 1) for start in starts]
    found = in_node(
        READ + "return data.asked.map(([seed, start]) => told(graph, new umg.WalkReel(graph, seed, start), 0, 2000))",
        {"site": site, "asked": asked},
    )
    for (seed, start), frames in zip(asked, found, strict=True):
        assert_same(frames, random_walk(graph, capture, 2000, seed, start), capture)


def test_the_published_walks_are_the_pages():
    published = json.loads((Path(__file__).parents[2] / "docs" / "walks.json").read_text())
    site, _, _ = site_of(*random_case(7, 60, 3))
    found = in_node(
        READ + "return data.seeds.map((seed) => told(graph, new umg.WalkReel(graph, seed, graph.start), 0, 300))",
        {"site": {**site, "graph": published["graph"]}, "seeds": [walk["seed"] for walk in published["walks"]]},
    )
    for walk, frames in zip(published["walks"], found, strict=True):
        assert [frame[0] for frame in frames] == walk["frames"]


@pytest.mark.parametrize("case", range(3))
def test_ways_to_a_frame_are_those_of_umg_path_and_the_walk_goes_on_from_there(case):
    """From captured frames and from the middle of transitions, which are played to their end first."""
    site, graph, capture = site_of(*random_case(case, 120, 6))
    random = np.random.default_rng(case)
    asked = [[int(random.integers(0, 300)), int(random.choice(graph.frames))] for _ in range(12)]
    found = in_node(
        READ
        + """return data.asked.map(([index, goal]) => {
          const reel = new umg.WalkReel(graph, 5, graph.start), [turn] = reel.turningPoint(index);
          const shown = reel.goTo(index, goal);
          return [turn, shown, told(graph, reel, 0, shown + 200)];
        })""",
        {"site": site, "asked": asked},
    )
    for (index, goal), (turn, shown, frames) in zip(asked, found, strict=True):
        before = list(islice(endless_walk(graph, 5, int(graph.frames[0])), turn + 1))
        assert all(frame.transition is not None for frame in before[index:-1]) and before[-1].frame is not None
        way = path_walk(graph, capture, PathRequest(before[-1].frame, goal))
        after = list(islice(endless_walk(graph, 5, goal), 201))
        assert shown == turn + len(way) - 1 and len(frames) == shown + 200
        assert [frame[0] for frame in frames] == [
            frame_label(frame, capture) for frame in [*before, *list(way)[1:], *after[1:200]]
        ]
        assert_same(frames[: turn + 1], before, capture)


def test_the_world_goes_on_along_a_way():
    """Where walk and path meet the motions multiply: the page's world after a way is the walk's, then the path's."""
    site, graph, capture = site_of(*random_case(1, 120, 6))
    goal = int(graph.frames[20])
    turn, shown, frames = in_node(
        READ
        + """const reel = new umg.WalkReel(graph, 5, graph.start), [turn] = reel.turningPoint(150);
          const shown = reel.goTo(150, data.goal);
          return [turn, shown, told(graph, reel, 0, shown + 1)];""",
        {"site": site, "goal": goal},
    )
    walked = random_walk(graph, capture, turn + 1, 5).frames[-1]
    way = path_walk(graph, capture, PathRequest(walked.frame, goal)).frames[-1]
    whole = walked.world.after(way.world)
    np.testing.assert_allclose(frames[shown][2:], [whole.x, whole.y], atol=1e-9)
    assert math.cos(frames[shown][1] - whole.yaw) == pytest.approx(1)


@pytest.mark.parametrize("case", range(2))
def test_a_loop_is_the_shortest_way_back_over_and_over(case):
    site, graph, capture = site_of(*random_case(case, 120, 6))
    asked = [int(frame) for frame in graph.frames[::9]]
    found = in_node(
        READ
        + """return data.asked.map((frame) => {
          const reel = new umg.WalkReel(graph, 1, frame);
          return [reel.loopFrom(0), told(graph, reel, 0, 800)];
        })""",
        {"site": site, "asked": asked},
    )
    after = successors(graph)
    for frame, (looped, frames) in zip(asked, found, strict=True):
        names, start = [each[0] for each in frames], capture.frame_id(frame)
        assert looped
        period = names.index(start, 1)
        assert names == (names[:period] * (800 // period + 1))[:800]
        assert all(b in after[a] for a, b in zip(names, names[1:], strict=False))
        assert period == breadth_first(after, start)


def successors(graph):
    """Straight from the graph's segments: which names follow a name."""
    after: dict[str, set[str]] = {}
    for edge in graph.edges:
        names = [str(int(graph.nodes[edge.source]) + 1)]
        for part in edge.segments:
            link = None if part.link is None else graph.links[part.link]
            for i in range(part.first, part.last + 1):
                names.append(str(i + 1) if link is None else f"{link.source + 1}>{link.target + 1}:{i}")
        for a, b in zip(names, names[1:], strict=False):
            after.setdefault(a, set()).add(b)
    return after


def breadth_first(after, start):
    """Steps of the shortest way from a name back to it."""
    reached, steps = {start}, 0
    while True:
        steps += 1
        reached = {b for a in reached for b in after[a]}
        if start in reached:
            return steps


def test_a_graph_that_ends_ends_the_walk_and_has_no_loops():
    capture = toy_capture(30, 60)
    site, graph, capture = site_of(capture, [Link(50, 80, 3, PlanarRigid(), 0.0)])
    assert not graph.cyclic
    length, looped, way = in_node(
        READ
        + """const reel = new umg.WalkReel(graph, 1, graph.start);
          reel.frame(100000);
          return [reel.known, reel.loopFrom(3), reel.goTo(3, 5)];""",
        {"site": site},
    )
    assert length == len(random_walk(graph, capture, 100000, 1))
    assert looped is False and way is None
    with pytest.raises(UserError):
        path_walk(graph, capture, PathRequest(33, 5))


def test_a_walk_keeps_what_it_needs_and_no_more():
    """Hours on, its memory is bounded and it still shows the right ones."""
    site, graph, capture = site_of(*random_case(0, 120, 6))
    kept, first, frames = in_node(
        READ
        + """const reel = new umg.WalkReel(graph, 1, graph.start);
          reel.frame(200000);
          return [reel.blocks.length, reel.first, told(graph, reel, 199990, 200000)];""",
        {"site": site},
    )
    walk = list(islice(endless_walk(graph, 1, int(graph.frames[0])), 199990, 200000))
    assert kept <= 4096 and first > 50000
    assert [frame[0] for frame in frames] == [frame_label(frame, capture) for frame in walk]


def test_a_transition_is_shown_between_its_captured_frames_in_the_sources_place():
    capture, links = signal_capture(60), signal_links((10, 40))
    site = site_to_json(build_graph(capture, links), capture)
    frames, seams = in_node(
        READ
        + """const reel = new umg.TransitionReel(graph, 0, () => ({first: 5, last: 44}), 6);
          return [told(graph, reel, 0, 100), reel.seams];""",
        {"site": site},
    )
    names = [frame[0] for frame in frames]
    assert names == ["6", "7", "8", *(f"11>41:{step}" for step in range(-2, 3)), "44", "45"]
    assert [names[seam : seam + 2] for seam in seams] == [["8", "11>41:-2"], ["11>41:2", "44"]]
    assert [frame[1:] for frame in frames[:8]] == [[0, 0, 0]] * 8
    assert frames[8][1:] == frames[9][1:] == pytest.approx([0.4, 0.3, -0.2])


DECODE = """
const bytes = Uint8Array.from(Buffer.from(data, "base64"));
const { header, positions, index, uv, flow, colors, images } = await umg.decodeArrays(umg.stringBytes(bytes));
return { header, positions: [...positions], index: [...index], uv: uv && [...uv], flow: flow && [...flow],
  colors: colors.map((each) => [...each]), images: await Promise.all(images.map(async (image) =>
    [image.type, Buffer.from(await image.arrayBuffer()).toString("base64")])) };
"""


def decoded(content):
    return in_node(DECODE, base64.b64encode(content).decode(), "decode")


def assert_decoded(content):
    ours, theirs = read_site_file(content), decoded(content)
    steps, corners = len(ours.positions), ours.header["corners"]
    assert theirs["header"] == ours.header
    positions = np.array(theirs["positions"]).reshape(steps, corners, 4)
    np.testing.assert_allclose(positions[..., :3] * ours.header["step"] + ours.header["low"], ours.positions)
    np.testing.assert_array_equal(np.array(theirs["index"]).reshape(-1, 3), ours.faces)
    for name in ("uv", "flow"):
        values = getattr(ours, name)
        assert (theirs[name] is None) == (values is None)
        if values is not None:
            head = ours.header[name]
            np.testing.assert_allclose(np.array(theirs[name]).reshape(-1, 2) * head["step"] + head["low"], values)
    shades = np.array(theirs["colors"]).reshape(len(ours.colors), corners, 4)[..., :3]
    np.testing.assert_array_equal(shades, ours.colors.reshape(shades.shape))
    assert [kind for kind, _ in theirs["images"]] == ["image/webp"] * len(ours.images)


def test_files_are_decoded_to_the_same_arrays():
    capture = signal_capture(20)
    assert_decoded(frame_file(capture.read(7), "8", "frames/8", SiteOptions()))
    assert_decoded(transition_file(signal_transition(10, 40), "11", "41", "transitions/11-41", SiteOptions()))


def test_a_large_coloured_frame_is_decoded_to_the_same_arrays():
    count = 70_000
    random = np.random.default_rng(0)
    start = np.arange(count - 2, dtype=np.int32)
    mesh = TexturedMesh(
        random.random((count, 3)), np.stack([start, start + 2, start + 1], 1),
        colors=random.integers(0, 256, (count, 3)).astype(np.uint8),
    )  # fmt: skip
    assert_decoded(frame_file(mesh, "1", "frames/1", SiteOptions()))


@pytest.mark.parametrize("damage", ["cut", "changed"])
def test_damage_does_not_pass(damage):
    content = frame_file(signal_capture(20).read(7), "8", "frames/8", SiteOptions())
    middle = len(content) // 2
    content = (
        content[:middle] if damage == "cut" else content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]
    )
    with pytest.raises(AssertionError, match="Error"):
        decoded(content)


PLAY = """
const held = new Map(), failed = new Map(data.failed.map((key) => [key, 1]));
let now = 0;
const loader = { failed, get: (key) => held.get(key), want: (keys) => { loader.keys = keys; } };
const give = (...keys) => keys.forEach((key) => held.set(key, { key }));
const player = new umg.Player(new umg.CaptureReel(data.count), 30, loader, () => now);
const tick = (seconds) => { now += seconds; const shown = player.tick(); return shown && shown.item.frame; };
"""


def test_the_frame_is_chosen_from_elapsed_time_at_any_rate_of_pictures():
    shown = in_node(
        PLAY
        + """give(...Array.from({length: 300}, (_, i) => `f${i}`)); player.play(true);
          return data.gaps.map((gap) => tick(gap))""",
        {"count": 300, "failed": [], "gaps": [0.0, 0.01, 0.024, 0.1, 0.2, 1 / 30, 0.001] * 5},
    )
    times = np.cumsum([0.0, 0.01, 0.024, 0.1, 0.2, 1 / 30, 0.001] * 5)
    assert shown == [int(30 * time + 1e-9) for time in times]


def test_time_waits_for_what_is_not_there_and_goes_on_with_it():
    shown = in_node(
        PLAY
        + """player.play(true); const told = [];
          give("f0", "f1"); told.push(tick(0), tick(0.04));
          for (let i = 0; i < 100; i++) told.push(tick(0.05));
          const held_at = player.index; give(...loader.keys);
          return [told, held_at, tick(0.04), tick(0.04)];""",
        {"count": 300, "failed": []},
    )
    told, held_at, first, second = shown
    assert told[:2] == [0, 1] and all(frame is None for frame in told[2:])
    assert 5 <= held_at <= 12 and first in (held_at, held_at + 1) and second in (first + 1, first + 2)


def test_what_cannot_be_used_is_passed_over_and_a_reel_starts_again():
    shown = in_node(
        PLAY
        + """give("f0", "f1", "f4", "f5"); player.play(true);
          return Array.from({length: 9}, (_, i) => tick(i ? 1 / 30 + 1e-6 : 0))""",
        {"count": 6, "failed": ["f2", "f3"]},
    )
    assert shown == [0, 1, 4, 5, 0, 1, 4, 5, 0]


def test_without_loop_the_last_frame_stays():
    shown, playing = in_node(
        PLAY
        + """give("f0", "f1", "f2"); player.loop = false; player.play(true);
          return [Array.from({length: 6}, (_, i) => tick(i ? 1 / 30 + 1e-6 : 0)), player.playing]""",
        {"count": 3, "failed": []},
    )
    assert shown == [0, 1, 2, 2, 2, 2] and playing is False


def test_what_is_played_next_is_read_first_over_the_end_of_a_reel():
    keys = in_node(PLAY + "player.play(true); player.seek(4); tick(0); return loader.keys", {"count": 6, "failed": []})
    assert keys == ["f4", "f5", "f0", "f1", "f2", "f3"]


def test_the_page_links_to_nothing_outside():
    folder = files("unstructured_mg.playback").joinpath("web")
    for item in folder.iterdir():
        text = item.read_text(encoding="utf-8")
        assert set(re.findall(r"(?:https?:)?//[a-z][\w.-]*\.[a-z]{2,}[\w/.]*", text)) <= {
            "//www.w3.org/2000/svg",
            "http://www.w3.org/2000/svg",
        }
        assert not re.search(r"@import|url\(", text)
