from dataclasses import replace

import numpy as np
import pytest
from tracking.walkers import swaying

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import Refusal
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.tracking.cage import build_cage
from unstructured_mg.tracking.embedding import embed, tet_rotations
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.template import select_template
from unstructured_mg.tracking.track import track_pair

OPTIONS = TrackingOptions(cage_vertices=400)
K = 2
# Windows around 4 and 14: the second half is the first, turned by 0.9 and moved.
CANDIDATE = Candidate(source=4, target=14, score=0.0, yaw=-0.9, k=K)


@pytest.fixture(scope="module")
def capture():
    return swaying(20)


@pytest.fixture(scope="module")
def pair(capture):
    template = select_template(capture, CANDIDATE, OPTIONS)
    return track_pair(capture, CANDIDATE, template, build_cage(capture.read(template), OPTIONS), OPTIONS)


def test_the_template_follows_the_true_motion_in_both_windows(capture, pair):
    template = int(pair.frames[pair.template])
    rest, _ = capture.rest(template)
    assert pair.vertices.shape == (4 * K + 2, len(rest), 3)
    for position, frame in enumerate(pair.frames):
        error = np.linalg.norm(pair.vertices[position] - capture.pose(int(frame), rest), axis=1)
        assert np.sqrt(np.mean(error**2)) < 6e-3 and error.max() < 2e-2
    assert pair.measures["hausdorff_m"].max() < 5e-3
    np.testing.assert_array_equal(pair.frames, [2, 3, 4, 5, 6, 12, 13, 14, 15, 16])


def test_the_template_frame_is_the_captured_surface_without_its_debris(capture, pair):
    template = int(pair.frames[pair.template])
    rest, faces = capture.rest(template)
    np.testing.assert_array_equal(pair.vertices[pair.template], capture.pose(template, rest))
    np.testing.assert_array_equal(pair.faces, faces)


def test_cage_and_residual_give_the_surface_and_no_tet_is_inverted(pair):
    cage_rest = pair.cage_vertices[pair.template]
    for position in range(len(pair.frames)):
        cage = pair.cage_vertices[position]
        rotations = tet_rotations(cage_rest, pair.tets, cage)
        surface = embed(cage, pair.tets, pair.tet_of_vertex, pair.weights, rotations, pair.residual[position])
        np.testing.assert_allclose(surface, pair.vertices[position], atol=1e-12)
        assert tet_volumes(cage, pair.tets).min() > 0
        # The cage carries the surface: what is left to the residual is small.
        assert np.linalg.norm(pair.residual[position], axis=1).max() < 5e-3
    np.testing.assert_allclose(pair.weights.sum(1), 1)


def test_the_same_pair_twice_has_the_same_bytes(capture, pair):
    template = int(pair.frames[pair.template])
    again = track_pair(capture, CANDIDATE, template, build_cage(capture.read(template), OPTIONS), OPTIONS)
    assert again.vertices.tobytes() == pair.vertices.tobytes()
    assert again.cage_vertices.tobytes() == pair.cage_vertices.tobytes()


class Grown:
    """A capture whose target window has a body half as large again."""

    def __init__(self, capture):
        self.capture = capture

    def read(self, index):
        mesh = self.capture.read(index)
        return TexturedMesh(mesh.vertices * (1.5 if index >= 10 else 1.0), mesh.faces)


def test_warped_windows_are_tracked_frame_by_frame(capture):
    """Windows of four and of five frames, one pose held: every frame once, and the steps say what belongs together."""
    warp = (2, 3, 3, 4, 5), (12, 13, 14, 15, 16)
    candidate = Candidate(source=3, target=14, score=0.0, yaw=-0.9, k=2, warp=warp)
    assert candidate.windows == (range(2, 6), range(12, 17))
    pair = track_pair(capture, candidate, 4, build_cage(capture.read(4), OPTIONS), OPTIONS)
    assert pair.frames.tolist() == [2, 3, 4, 5, 12, 13, 14, 15, 16]
    np.testing.assert_array_equal(pair.frames[pair.steps], warp)
    assert pair.windows == (slice(0, 4), slice(4, 9))
    # The template's own window is tracked as in straight windows; the other is reached from another frame.
    straight = track_pair(capture, Candidate(4, 14, 0.0, -0.9, 2), 4, build_cage(capture.read(4), OPTIONS), OPTIONS)
    np.testing.assert_array_equal(straight.vertices[:4], pair.vertices[:4])
    np.testing.assert_allclose(straight.vertices[5:10], pair.vertices[4:], atol=2e-3)


def test_a_target_out_of_reach_is_refused_with_the_distance(capture):
    grown = Grown(capture)
    refusal = track_pair(grown, CANDIDATE, 4, build_cage(grown.read(4), OPTIONS), OPTIONS)
    assert isinstance(refusal, Refusal)
    assert refusal.stage == "tracking"
    assert refusal.measures["hausdorff_m"] > OPTIONS.hausdorff_m
    assert f"{100 * refusal.measures['hausdorff_m']:.1f} cm" in refusal.reason


class SmallAndGrown:
    """A capture of a hand's size whose target window has a body larger by six tenths: near enough, and not the same."""

    def __init__(self, capture):
        self.capture = capture

    def read(self, index):
        mesh = self.capture.read(index)
        return TexturedMesh(mesh.vertices * (0.08 if index >= 10 else 0.05), mesh.faces)


def test_a_target_reached_by_stretching_is_refused_though_it_is_near(capture):
    grown = SmallAndGrown(capture)
    refusal = track_pair(grown, CANDIDATE, 4, build_cage(grown.read(4), OPTIONS), OPTIONS)
    assert isinstance(refusal, Refusal) and refusal.stage == "tracking"
    assert "stretched" in refusal.reason and "frame 14" in refusal.reason
    assert refusal.measures["stretch_p95"] > OPTIONS.stretch


def test_a_template_outside_the_pair_is_an_error(capture):
    with pytest.raises(ValueError, match="template"):
        track_pair(capture, CANDIDATE, 9, build_cage(capture.read(9), OPTIONS), OPTIONS)


def test_options_out_of_range_name_themselves():
    for field, value in (
        ("cage", "none"),
        ("hausdorff_m", 0.0),
        ("stretch", 1.0),
        ("debris_share", 1.0),
        ("cage_vertices", 3),
    ):
        with pytest.raises(ValueError, match=field):
            replace(OPTIONS, **{field: value})
