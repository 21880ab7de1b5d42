import json
from pathlib import Path

from toy_graph import random_case

from unstructured_mg.graph.files import graph_from_json
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.playback.conformance import SEEDS, conformance_walks, frame_label
from unstructured_mg.playback.walk import random_walk


def test_walks_are_those_of_umg_walk():
    capture, links = random_case(3)
    graph = build_graph(capture, links)
    told = conformance_walks(graph, capture, 200)
    assert json.loads(json.dumps(told)) == told
    assert [walk["seed"] for walk in told["walks"]] == list(SEEDS)
    for walk in told["walks"]:
        played = random_walk(graph, capture, 200, walk["seed"])
        assert walk["frames"] == [frame_label(frame, capture) for frame in played]
        assert told["start"] == walk["frames"][0]


def test_labels_name_captured_frames_and_steps():
    capture, links = random_case(3)
    walk = random_walk(build_graph(capture, links), capture, 400, 1)
    step = next(frame for frame in walk if frame.transition is not None)
    source, target = step.transition
    assert frame_label(step, capture) == f"{capture.frame_id(source)}>{capture.frame_id(target)}:-2"
    assert frame_label(walk.frames[0], capture) == capture.frame_id(walk.start)


def test_the_published_walks_are_ours():
    """docs/walks.json: a small graph and its walks, for those who write players."""
    published = json.loads((Path(__file__).parents[2] / "docs" / "walks.json").read_text())
    capture, _ = random_case(7, 60, 3)
    # The graph as published: probabilities made anew may differ in their last digits between machines.
    graph = graph_from_json(published.pop("graph"), capture)
    assert published == conformance_walks(graph, capture, 300)
