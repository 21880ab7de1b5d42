import dataclasses

import numpy as np
import pytest
from textured_pairs import ArrayTexture, pattern
from toy_pair import bending_pair

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import Refusal
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.synthesize import synthesize
from unstructured_mg.synthesis.texture_options import TextureOptions

ALONE = SynthesisOptions(texture="none")
COARSE = TextureOptions(edge_length=0.03, levels=3)


class PaintedCapture:
    """Frames as tracked, painted front and back."""

    def __init__(self, pair):
        self.pair = pair
        place = np.stack(np.meshgrid(np.linspace(0, 2, 128), np.linspace(1, 0, 64)), axis=-1)
        self.image = pattern(place, finest=15)
        rest = pair.vertices[0][pair.faces]
        behind = np.cross(rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0])[:, 0] < 0
        self.uv = np.stack([0.25 + 2 * rest[:, :, 1] + 0.5 * behind[:, None], 0.02 + 0.96 * rest[:, :, 2]], axis=-1)

    def read(self, index):
        position = int(np.flatnonzero(self.pair.frames == index)[0])
        texture = ArrayTexture(self.image.astype(np.uint8))
        face_uv = np.arange(self.pair.faces.size, dtype=np.int32).reshape(-1, 3)
        return TexturedMesh(
            self.pair.vertices[position], self.pair.faces, self.uv.reshape(-1, 2), face_uv, textures=(texture,)
        )


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
    refusal = synthesize(TrackedCapture(pair), pair, dataclasses.replace(ALONE, foot_slide=0.02))
    assert isinstance(refusal, Refusal) and refusal.stage == "synthesis"
    assert refusal.reason.startswith("on the way over the surface jumps at its start by")
    assert "the velocity jumps at its end" in refusal.reason and "feet slide" in refusal.reason
    assert refusal.measures["start_velocity_m"] > 0
    assert all(isinstance(value, float) for value in refusal.measures.values())


def test_a_window_needs_an_inside():
    with pytest.raises(ValueError, match="k"):
        synthesize(TrackedCapture(swaying_pair()), bending_pair(1), ALONE)


def test_textures_come_with_the_frames_and_their_measures_with_the_card():
    pair = swaying_pair()
    capture = PaintedCapture(pair)
    pair = dataclasses.replace(pair, uv=capture.uv.reshape(-1, 2), face_uv=capture.read(0).face_uv)
    for method in ("flow", "crossfade"):
        over, back = synthesize(capture, pair, SynthesisOptions(texture=method, texturing=COARSE))
        for transition in (over, back):
            assert len(transition.textures) == len(transition.vertices) == 7
            assert transition.face_uv.shape == pair.faces.shape
            assert transition.face_uv.max() < len(transition.uv)
            assert transition.card["texture"]["sharpness"] > 0.8
            assert transition.card["start"]["colour_levels"] < 4


def test_a_seam_that_changes_colour_more_than_the_capture_is_refused():
    """Strict to a hundredth of a grey level, which no atlas made anew can meet."""
    pair = swaying_pair()
    capture = PaintedCapture(pair)
    pair = dataclasses.replace(pair, uv=capture.uv.reshape(-1, 2), face_uv=capture.read(0).face_uv)
    refusal = synthesize(capture, pair, SynthesisOptions(colour_jump=0.0, colour_jump_floor=0.01, texturing=COARSE))
    assert isinstance(refusal, Refusal)
    assert "the colour jumps at its start" in refusal.reason
    assert refusal.measures["texture_sharpness"] > 0


def test_a_warped_pair_leaves_and_arrives_where_its_warp_says():
    moved = PlanarRigid(0.8, 3.0, -1.0)
    pair = swaying_pair(moved)
    # Six source frames and nine target frames in nine steps, the slower one held.
    kept = np.array([1, 2, 3, 4, 5, 6, *range(9, 18)])
    warp = np.array([[0, 0, 1, 1, 2, 3, 4, 4, 5], range(6, 15)], np.int32)
    names = ("frames", "vertices", "cage_vertices", "residual")
    warped = dataclasses.replace(pair, **{name: getattr(pair, name)[kept] for name in names}, warp=warp)
    over, back = synthesize(TrackedCapture(warped), warped, dataclasses.replace(ALONE, velocity_jump=1e9))
    assert over.ends == (pair.frames[1], pair.frames[17]) and back.ends == (pair.frames[9], pair.frames[6])
    assert len(over.vertices) == len(back.vertices) == 7
    # Close to the capture at the ends, as far as one step of nine goes.
    np.testing.assert_allclose(over.vertices[0], pair.vertices[1], atol=0.02)
    np.testing.assert_allclose(over.alignment.inverse().apply(over.vertices[-1]), pair.vertices[16], atol=0.02)
    np.testing.assert_allclose(back.vertices[-1], over.alignment.inverse().apply(pair.vertices[6]), atol=0.05)
