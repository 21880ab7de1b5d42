import numpy as np
import pytest
from toy_capture import toy_capture
from toy_graph import random_case

from unstructured_mg.errors import UserError
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.targets import target_weights

CAPTURE = toy_capture(5, 6, clips=True)


def test_clips_frames_and_ranges_are_weighed_and_the_last_word_counts():
    weights = target_weights(CAPTURE, ["a=3", "b:2..b:4=0.5", "b:4=2", "a:1=1"])
    assert weights.tolist() == [1, 3, 3, 3, 3, 1, 0.5, 0.5, 2, 1, 1]
    assert target_weights(CAPTURE, []).tolist() == [1] * 11


def test_what_names_nothing_is_said():
    with pytest.raises(UserError, match="no usable frame"):
        target_weights(CAPTURE, ["c=3"])
    with pytest.raises(UserError, match="comes before"):
        target_weights(CAPTURE, ["b:4..b:2=3"])
    for wish in ("a", "a=", "=2", "a=0", "a=-1", "a=inf"):
        with pytest.raises(ValueError, match="^visits"):
            GraphOptions(visits=(wish,))


@pytest.mark.parametrize("method", ["choice", "entropy"])
def test_wanted_frames_are_visited_more(method):
    capture, links = random_case(3, 120, 6)
    plain = build_graph(capture, links, GraphOptions(alpha=0.5, probabilities=method))
    chosen = np.argsort(plain.visits)[: len(plain.frames) // 3]
    wishes = tuple(f"{capture.frame_id(int(frame))}=4" for frame in plain.frames[chosen])
    wished = build_graph(capture, links, GraphOptions(alpha=0.5, probabilities=method, visits=wishes))
    assert wished.visits[chosen].sum() > 1.1 * plain.visits[chosen].sum()
    assert wished.visits.sum() == pytest.approx(1)
