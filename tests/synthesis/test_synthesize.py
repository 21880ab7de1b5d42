import numpy as np
import pytest
from toy_pair import bending_pair

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import Refusal
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.synthesize import synthesize

ALONE = SynthesisOptions(texture="none")


class TrackedCapture:
    """A capture whose frames are what was tracked, another triangle first in each."""

    def __init__(self, pair):
        self.pair = pair
        self.read_frames = []

    def read(self, index):
        self.read_frames.append(index)
        position = int(np.flatnonzero(self.pair.frames == index)[0])
        return TexturedMesh(self.pair.vertices[position], np.roll(self.pair.faces, index, axis=0))


def swaying_pair(moved=None):
    """Both windows sway through the same angles but for 0.03 rad."""
    angles = 0.4 * np.sin(np.linspace(0, 2.5, 9))
    return bending_pair(4, angles, angles + 0.03, moved)


def test_both_directions_join_the_captured_frames():
    moved = PlanarRigid(0.8, 3.0, -1.0)
    pair = swaying_pair(moved)
    over, back = synthesize(TrackedCapture(pair), pair, ALONE)
    assert (over.source, over.target, back.source, back.target) == (4, 104, 104, 4)
    assert over.vertices.shape == (7, *pair.vertices.shape[1:])
    step = np.abs(np.diff(pair.vertices[:9], axis=0)).max()
    for transition, before, after in ((over, 0, 17), (back, 9, 8)):
        sequence = np.concatenate(
            [pair.vertices[[before]], transition.vertices, transition.alignment.apply(pair.vertices[[after]])]
        )
        assert np.abs(np.diff(sequence, axis=0)).max() < 1.3 * step
    np.testing.assert_allclose(over.alignment.after(back.alignment).matrix(), np.eye(4), atol=1e-12)
    np.testing.assert_allclose(over.alignment.yaw, -moved.yaw, atol=0.01)


def test_swapping_source_and_target_swaps_the_transitions():
    angles = 0.4 * np.sin(np.linspace(0, 2.5, 9))
    pair, swapped = bending_pair(4, angles, angles + 0.03), bending_pair(4, angles + 0.03, angles)
    over, back = synthesize(TrackedCapture(pair), pair, ALONE)
    other_over, other_back = synthesize(TrackedCapture(swapped), swapped, ALONE)
    # The template's shape differs, which is all that may tell.
    np.testing.assert_allclose(other_back.vertices, over.vertices, atol=1e-4)
    np.testing.assert_allclose(other_over.vertices, back.vertices, atol=1e-4)


def test_few_frames_are_read():
    pair = swaying_pair()
    capture = TrackedCapture(pair)
    synthesize(capture, pair, ALONE)
    assert capture.read_frames == [0, 1, 7, 8, 100, 101, 107, 108]


def test_a_pair_that_does_not_fit_is_refused_with_its_numbers():
    still = np.zeros(9)
    pair = bending_pair(4, still, still + 1.5)
    refusal = synthesize(TrackedCapture(pair), pair, ALONE)
    assert isinstance(refusal, Refusal) and refusal.stage == "synthesis"
    assert refusal.reason.startswith("On the way over, the surface jumps at its start by")
    assert "the velocity jumps at its end" in refusal.reason and "feet slide" in refusal.reason
    assert refusal.measures["start_velocity_m"] > 0
    assert all(isinstance(value, float) for value in refusal.measures.values())


def test_a_window_needs_an_inside():
    with pytest.raises(ValueError, match="k"):
        synthesize(TrackedCapture(swaying_pair()), bending_pair(1), ALONE)
