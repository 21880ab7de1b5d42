import numpy as np
import pytest
from array_capture import array_capture, figure

from unstructured_mg.matching.candidates import is_near
from unstructured_mg.matching.match import match
from unstructured_mg.matching.options import MatchingOptions


@pytest.fixture(scope="module")
def repeats():
    """A swing, a turn standing still, and the swing again: facing elsewhere, re-meshed, from frame 40 on."""
    swing = [2 * np.pi * i / 20 for i in range(20)]
    frames = [figure(phase, seed=i) for i, phase in enumerate(swing)]
    frames += [figure(0.0, 1.2 * np.sin(np.pi * i / 40), seed=50 + i) for i in range(20)]
    frames += [figure(phase, 1.2, seed=90 + i) for i, phase in enumerate(swing)]
    return array_capture(frames)


def test_a_repeated_action_is_found_where_it_repeats(repeats, tmp_path):
    options = MatchingOptions(k=4, minimum_gap_seconds=0.5, resolution=32)
    matching = match(repeats, options, scratch=tmp_path)
    assert matching.threshold == pytest.approx(0.04 * 1.8, rel=0.05)
    best = matching.candidates[0]
    assert best.target - best.source == 40
    assert best.yaw == pytest.approx(-1.2, abs=np.radians(1))
    kept = []
    for candidate in matching.candidates:
        if not is_near(candidate, kept, repeats, options):
            kept.append(candidate)
    assert all(candidate.score <= matching.threshold for candidate in matching.candidates)
    # A swing passes its middle twice a period, once forwards and once back: not to be mixed up.
    assert {(c.target - c.source) % 20 for c in kept if c.source < 20 and c.target >= 40} <= {0, 1, 19}
    assert matching.nearest[0] == best


def test_a_capture_without_repeats_has_nearest_pairs_only(tmp_path):
    capture = array_capture([figure(0.04 * i, position=(0.02 * i * i / 30, 0, 0.01 * i), seed=i) for i in range(40)])
    matching = match(capture, MatchingOptions(k=4, minimum_gap_seconds=0.7, resolution=32), scratch=tmp_path)
    assert matching.candidates == ()
    assert len(matching.nearest) > 0 and matching.nearest[0].score > matching.threshold
