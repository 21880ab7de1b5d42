import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from memory_capture import memory_capture

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.playback.frame_axis import frame_axis
from unstructured_mg.playback.plot_timeline import SIDE, WIDTH, plot_timeline
from unstructured_mg.playback.report_data import TransitionEntry

CAPTURE = memory_capture([("a", n) for n in range(60)] + [("b<", n) for n in range(40)])


def entry(source, target, cost, in_graph=True):
    return TransitionEntry(source, target, 5, PlanarRigid(), cost, {}, in_graph)


def test_arcs_lead_from_where_a_transition_leaves_to_where_it_arrives():
    entries = [entry(10, 80, 0.25), entry(80, 10, 0.5, in_graph=False)]
    svg = ElementTree.fromstring(plot_timeline(CAPTURE, None, entries))
    axis = frame_axis(CAPTURE, SIDE, WIDTH - SIDE)
    found = {}
    for link in svg.iter("a"):
        assert link.get("href") == "#pair-10-80"
        path = link.findall("path")[1]
        x0, y0, _, y1, _, _, x1, y2 = map(float, re.findall(r"-?[\d.]+", path.get("d")))
        assert y0 == y2
        found[path.get("class")] = (x0, x1, y1 < y0, link.find("title").text)
    there, back = found["arc"], found["arc unused"]
    assert there[:2] == pytest.approx((axis.x[5], axis.x[85]), abs=0.01) and there[2]
    assert back[:2] == pytest.approx((axis.x[75], axis.x[15]), abs=0.01) and not back[2]
    assert there[3] == "frame a:5 to frame b<:25, through a:10 and b<:20, cost 0.25"
    assert back[3].endswith("cost 0.5, outside the graph")


def test_frames_of_the_graph_are_emphasised_run_by_run():
    covered = np.zeros(100, bool)
    covered[20:70] = True
    svg = ElementTree.fromstring(plot_timeline(CAPTURE, covered, []))
    axis = frame_axis(CAPTURE, SIDE, WIDTH - SIDE)
    bars = [
        (float(bar.get("x")), float(bar.get("width")))
        for bar in svg.iter("rect")
        if bar.get("class") == "frames inside"
    ]
    half = axis.pitch / 2
    expected = [(axis.x[20] - half, 40 * axis.pitch), (axis.x[60] - half, 10 * axis.pitch)]
    np.testing.assert_allclose(bars, expected, atol=0.01)
    assert "b<" in [text.text for text in svg.iter("text")]
