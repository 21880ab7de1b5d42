import re
import xml.etree.ElementTree as ElementTree

import numpy as np
from memory_capture import memory_capture

from unstructured_mg.playback.frame_axis import frame_axis
from unstructured_mg.playback.plot_visits import HEIGHT, LEFT, SIDE, TOP, WIDTH, plot_visits


def read_stair(path):
    """Treads (left, right, y) of a path of M, V and H."""
    treads, x, y = [], 0.0, 0.0
    for command, numbers in re.findall(r"([MVH])([-\d. ]+)", path):
        values = [float(value) for value in numbers.split()]
        if command == "M":
            x, y = values
        elif command == "V":
            y = values[0]
        else:
            treads.append((x, values[0], y))
            x = values[0]
    return treads


def test_curves_have_the_height_of_the_shares_and_pause_outside_the_graph():
    capture = memory_capture([("a", n) for n in range(30)])
    covered = np.ones(30, bool)
    covered[12:15] = False
    share = np.where(covered, np.arange(30) // 3 + 1.0, 0.0)
    before, after = share / share.sum(), covered / 27
    svg = ElementTree.fromstring(plot_visits(capture, covered, before, after))
    curves = {path.get("class"): read_stair(path.get("d")) for path in svg.iter("path")}
    axis = frame_axis(capture, LEFT, WIDTH - SIDE)
    highest = 1.08 * 27 * before.max()
    for kind, shares in (("visits before", before), ("visits after", after)):
        for index in np.flatnonzero(covered):
            treads = [y for left, right, y in curves[kind] if left < axis.x[index] < right]
            assert len(treads) == 1
            assert abs(treads[0] - (TOP + HEIGHT * (1 - 27 * shares[index] / highest))) < 0.01
        assert not any(left < axis.x[index] < right for left, right, _ in curves[kind] for index in (12, 13, 14))
    assert len(curves["visits after"]) == 2
    (target,) = (mark for mark in svg.iter("line") if mark.get("class") == "target")
    assert float(target.get("y1")) == curves["visits after"][0][2]
