from dataclasses import replace

import numpy as np
from toy_capture import toy_capture

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.playback.decimated import decimated_frames, decimated_transition, decimated_transitions
from unstructured_mg.playback.stream import posed_frames
from unstructured_mg.playback.walk import WalkFrame, capture_walk
from unstructured_mg.synthesis.texture_flow import TextureFlow
from unstructured_mg.synthesis.transition import Transition

SIDE = 10
Y, X = np.mgrid[: SIDE + 1, : SIDE + 1].reshape(2, -1) / SIDE
START = np.arange(SIDE * (SIDE + 1)).reshape(SIDE, SIDE + 1)[:, :SIDE].ravel()
FACES = np.concatenate([
    np.stack([START, START + 1, START + SIDE + 2], 1), np.stack([START, START + SIDE + 2, START + SIDE + 1], 1)
]).astype(np.int32)  # fmt: skip
UV = np.stack([X, Y], 1)


def bent(phase):
    return np.stack([X, Y, 0.1 * np.sin(6 * X + phase)], 1)


def mesh(index):
    """Frames 0, 1, 4, 5, ... have one connectivity, 2, 3, 6, 7, ... another."""
    faces = np.roll(FACES, index // 2 % 2 * 7, axis=0)
    return TexturedMesh(bent(0.3 * index), faces, UV, faces)


CAPTURE = toy_capture(8, mesh_of=mesh)


def decimated(order):
    walk = [WalkFrame("capture", i, None, None, PlanarRigid(0.0, 1.0 * n, 0.0)) for n, i in enumerate(order)]
    return list(decimated_frames(posed_frames(walk, CAPTURE, None), CAPTURE, 40))


def test_frames_of_one_connectivity_lose_the_same_vertices():
    frames = decimated(range(8))
    for index, frame in enumerate(frames):
        like = frames[index // 2 % 2 * 2]
        assert len(frame.faces) <= 40 and frame.origin.frame == index
        np.testing.assert_array_equal(frame.faces, like.faces)
        np.testing.assert_array_equal(frame.uv, like.uv)
        np.testing.assert_array_equal(frame.face_uv, like.face_uv)
        # What is left is where it was.
        x, y = frame.uv.T
        np.testing.assert_allclose(frame.own_vertices, np.stack([x, y, 0.1 * np.sin(6 * x + 0.3 * index)], 1))


def test_a_frame_that_comes_again_is_the_same_whatever_came_between():
    first, _, again, *_ = decimated([1, 2, 1, 4, 0])
    np.testing.assert_array_equal(first.own_vertices, again.own_vertices)
    np.testing.assert_array_equal(first.faces, again.faces)
    np.testing.assert_allclose(again.vertices - first.vertices, np.broadcast_to([2.0, 0, 0], first.vertices.shape))


def test_small_frames_pass_as_they_are():
    frames = list(posed_frames(capture_walk(CAPTURE), CAPTURE, None))
    assert all(a is b for a, b in zip(frames, decimated_frames(frames, CAPTURE, len(FACES)), strict=True))


def transition():
    poses = np.stack([bent(phase) for phase in np.linspace(0, 3, 9)])
    return Transition(0, 7, 5, poses, FACES, UV, FACES, (b"",) * 9, ".png",
                      (255 * np.stack([poses[..., 0]] * 3, 2)).astype(np.uint8), PlanarRigid(), {})  # fmt: skip


def test_the_flow_stays_with_its_vertices():
    end = (255 * np.stack([X, Y, Y], 1)).astype(np.uint8)
    flow = TextureFlow(bent(0), np.stack([X, Y, X * Y], 1), np.stack([X + Y, X - Y], 1), (), "", np.stack([end, end]))
    small = decimated_transition(replace(transition(), flow=flow), 40)
    x, y = small.uv.T
    np.testing.assert_array_equal(small.flow.reference[:, :2], small.uv)
    np.testing.assert_array_equal(small.flow.displacement, np.stack([x, y, x * y], 1))
    np.testing.assert_array_equal(small.flow.uv_flow, np.stack([x + y, x - y], 1))
    np.testing.assert_array_equal(small.flow.colors[1], (255 * np.stack([x, y, y], 1)).astype(np.uint8))


def test_a_transition_keeps_one_connectivity_in_all_its_steps():
    whole = transition()
    small = decimated_transitions(lambda source, target: replace(whole, source=source, target=target), 40)(3, 4)
    assert (small.source, small.target, small.textures) == (3, 4, whole.textures)
    assert len(small.faces) <= 40 and small.vertices.shape == (9, len(small.uv), 3)
    for pose, phase in zip(small.vertices, np.linspace(0, 3, 9), strict=True):
        np.testing.assert_allclose(pose, np.stack([*small.uv.T, 0.1 * np.sin(6 * small.uv[:, 0] + phase)], 1))
    np.testing.assert_array_equal(small.colors[..., 0], (255 * small.vertices[..., 0]).astype(np.uint8))
    assert decimated_transition(whole, len(FACES)) is whole
