import json

import numpy as np
import pytest
from toy_capture import toy_capture
from toy_graph import placed_case, random_case

from unstructured_mg.errors import UserError
from unstructured_mg.graph.files import graph_from_json, graph_to_json
from unstructured_mg.graph.motion_graph import build_graph


def same(one, other):
    for name in ("frames", "nodes", "probabilities", "thresholds", "visits_even", "visits"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert getattr(getattr(one, name), "dtype", None) == getattr(getattr(other, name), "dtype", None)
    for name in ("links", "edges", "cyclic", "obstacles"):
        assert getattr(one, name) == getattr(other, name)


@pytest.mark.parametrize("pairs", [0, 5])
def test_a_graph_comes_back_as_it_was(pairs):
    capture, links = random_case(1, 120, pairs)
    graph = build_graph(capture, links)
    cards = {(link.source, link.target): {"seam": link.cost} for link in links}
    data = json.loads(json.dumps(graph_to_json(graph, capture, cards)))
    same(graph_from_json(data, capture), graph)
    assert [t["quality"]["seam"] for t in data["transitions"]] == [link.cost for link in graph.links]
    for transition, link in zip(data["transitions"], graph.links, strict=True):
        np.testing.assert_array_equal(transition["alignment"]["matrix"], link.alignment.matrix())


def test_places_come_back_to_a_micrometre():
    capture, graph = placed_case(0)
    again = graph_from_json(json.loads(json.dumps(graph_to_json(graph, capture, {}))), capture).places
    np.testing.assert_allclose(again.captured, graph.places.captured, atol=1e-6)
    for one, other in zip(again.steps, graph.places.steps, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6)


def test_frames_are_named_by_id():
    capture = toy_capture(20, 30, clips=True)
    data = graph_to_json(build_graph(capture, []), capture, {})
    assert data["nodes"] == ["a:1", "a:20", "b:1", "b:30"]
    assert data["edges"][1]["plays"] == [{"first": "b:2", "last": "b:30"}]
    assert data["visits"] is None and data["cyclic"] is False


def test_what_is_no_graph_of_this_version_is_refused():
    capture, links = random_case(1)
    data = graph_to_json(build_graph(capture, links), capture, {})
    for change in ({"version": 2}, {"format": "other"}):
        with pytest.raises(UserError, match=r"graph.json: format .* build the graph again"):
            graph_from_json({**data, **change}, capture)
