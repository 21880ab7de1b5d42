import json

from toy_capture import toy_capture

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.request import PathRequest
from unstructured_mg.playback.walk import path_walk, random_walk
from unstructured_mg.playback.walk_json import walk_text, walk_to_json
from unstructured_mg.playback.world import export_space

CAPTURE = toy_capture(100, 20, clips=True)
GRAPH = build_graph(CAPTURE, [Link(80, 10, 5, PlanarRigid(0.0, 1.0, 2.0), 0.0)])


def test_a_path_has_a_goal_and_no_seed():
    data = walk_to_json(path_walk(GRAPH, CAPTURE, PathRequest(74, 15)), CAPTURE, export_space(CAPTURE))
    assert (data["kind"], data["seed"], data["generator"]) == ("path", None, None)
    assert (data["start"], data["goal"]) == ("a:75", "a:16")
    assert [entry.get("step") for entry in data["frames"]] == [None, None, *range(-4, 5), None]
    assert data["frames"][2]["transition"] == {"source": "a:81", "target": "a:11"}
    assert data["frames"][-1] == {
        "source": "capture",
        "frame": "a:16",
        "world": [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 0], [0, 0, 0, 1]],
    }


def test_a_loop_says_where_its_next_round_stands_and_a_path_what_it_misses():
    loop = walk_to_json(path_walk(GRAPH, CAPTURE, PathRequest(74, loop=True)), CAPTURE, export_space(CAPTURE))
    assert (loop["kind"], loop["goal"], loop["remark"]) == ("loop", None, None)
    assert loop["again"] == [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 0], [0, 0, 0, 1]]
    path = walk_to_json(path_walk(GRAPH, CAPTURE, PathRequest(74, 15, frames=20)), CAPTURE, export_space(CAPTURE))
    assert path["again"] is None and path["remark"] == "The nearest possible length is 12 frames, 8 frames fewer."


def test_the_text_has_a_line_a_frame_and_says_the_same():
    walk = random_walk(GRAPH, CAPTURE, 30, 7)
    files = [f"{i}.obj" for i in range(30)]
    data = walk_to_json(walk, CAPTURE, export_space(CAPTURE), files, {"graph.json": "abc"})
    text = walk_text(data)
    assert json.loads(text) == data
    lines = [line for line in text.splitlines() if '"world"' in line]
    assert [json.loads(line.rstrip(","))["file"] for line in lines] == files
