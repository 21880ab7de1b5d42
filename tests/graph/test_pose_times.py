from itertools import product

import numpy as np
import pytest
from toy_graph import frame_successors, least_costs, placed_case, played_names

from unstructured_mg.errors import UserError
from unstructured_mg.graph.pose_times import through_poses


@pytest.mark.parametrize("seed", range(4))
def test_no_other_times_miss_less_or_cost_less(seed):
    capture, graph = placed_case(seed, 50, 2, k=2)
    random = np.random.default_rng(seed)
    frames = random.choice(graph.frames, 4).tolist()
    times = [0, *np.cumsum(random.integers(5, 60, 3)).tolist()]
    found = through_poses(graph, capture, frames, times)
    horizon = 260
    legs = [least_costs(graph, capture, a, b, horizon) for a, b in zip(frames, frames[1:], strict=False)]
    possible = [np.flatnonzero(np.isfinite(leg))[:40].tolist() for leg in legs]
    best = min(
        (
            sum(abs(t - w) for t, w in zip(np.cumsum(lengths).tolist(), times[1:], strict=True)),
            sum(leg[length] for leg, length in zip(legs, lengths, strict=True)),
        )
        for lengths in product(*possible)
    )
    missed = sum(abs(t - w) for t, w in zip(found.times, times, strict=True))
    assert (missed, pytest.approx(found.cost)) == best
    names = [frames[0], *played_names(graph, found.path.segments)]
    assert [names[time] for time in found.times] == frames and len(names) == found.times[-1] + 1
    after = frame_successors(capture.runs(), list(graph.links))
    for a, b in zip(names, names[1:], strict=False):
        assert b in after[a]


def test_a_pose_may_come_twice_and_what_cannot_be_reached_is_named():
    capture, graph = placed_case(1, 50, 2, k=2)
    frame = int(graph.frames[4])
    assert through_poses(graph, capture, [frame, frame], [0, 0]).times == (0, 0)
    line_capture, line = placed_case(0, 40, 0)
    with pytest.raises(UserError, match=f"Frame {line_capture.frame_id(5)} cannot be reached"):
        through_poses(line, line_capture, [20, 5], [0, 10])
