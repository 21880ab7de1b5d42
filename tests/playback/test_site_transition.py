from dataclasses import replace

import numpy as np
import pytest
from signal_toy import K, color, signal_transition
from site_reader import read_site_file

from unstructured_mg.errors import UserError
from unstructured_mg.playback.site_options import SiteOptions
from unstructured_mg.playback.site_transition import shortened_flow, transition_file

OPTIONS = SiteOptions(quality=95)
# Two charts side by side with a gap between: 0.05 .. 0.45 and 0.55 .. 0.95 of the width.
UV = np.array([[0.05, 0.1], [0.45, 0.1], [0.45, 0.9], [0.05, 0.9], [0.55, 0.1], [0.95, 0.1], [0.95, 0.9], [0.55, 0.9]])
FACE_UV = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.int32)


def moving_transition(seed=0):
    """Steps that wander, a flow that differs at every corner."""
    random = np.random.default_rng(seed)
    whole = signal_transition(10, 40)
    poses = whole.vertices + np.cumsum(random.normal(size=whole.vertices.shape), axis=0)
    return replace(whole, vertices=poses, flow=replace(whole.flow, uv_flow=random.normal(0, 0.05, (4, 2)).astype("f4")))


def test_every_step_is_where_it_was_to_half_a_step_of_the_grid():
    transition = moving_transition()
    file = read_site_file(transition_file(transition, "10", "40", "transitions/10-40", OPTIONS))
    assert file.header["transition"] == ["10", "40"] and file.positions.shape == (5, 4, 3)
    corner = np.abs(file.positions[0][:, None] - transition.vertices[0]).sum(axis=2).argmin(axis=1)
    assert np.abs(file.positions - transition.vertices[:, corner]).max() <= file.header["step"] / 2 * (1 + 1e-6)
    assert np.abs(file.uv - np.stack([transition.uv[:, 0], 1 - transition.uv[:, 1]], 1)[corner]).max() < 0.25 / 16
    for image, frame in zip(file.images, (10 - K, 40 + K), strict=True):
        assert np.abs(image.astype(int) - color(frame)).max() <= 4


def test_the_flow_at_a_corner_is_the_shortened_one_downwards():
    transition = moving_transition()
    kept, share = shortened_flow(transition.uv, transition.face_uv, transition.flow.uv_flow.astype(float), 16, 16)
    file = read_site_file(transition_file(transition, "10", "40", "t", OPTIONS))
    corner = np.abs(file.positions[0][:, None] - transition.vertices[0]).sum(axis=2).argmin(axis=1)
    assert np.abs(file.flow - (kept * [1, -1])[corner]).max() < 0.25 / 16 / 8


def test_a_transition_without_its_flow_is_an_earlier_versions():
    with pytest.raises(UserError, match="from 10 to 40 has no flow.npz.*umg build"):
        transition_file(replace(signal_transition(10, 40), flow=None), "10", "40", "t", OPTIONS)


def test_flow_inside_a_chart_is_kept_and_flow_to_another_chart_is_shortened():
    size = 400
    inwards = np.where(UV < 0.5, 0.1, -0.1) * [0, 1] + [[0.1, 0], [-0.1, 0], [-0.1, 0], [0.1, 0]] * 2
    # A move is looked up both ways: what goes inwards for one end goes outwards for the other.
    kept, share = shortened_flow(UV, FACE_UV, inwards, size, size)
    assert (share < 0.2).all()
    centre = np.array([[0.25, 0.5], [0.26, 0.5], [0.25, 0.51]])
    uv, faces = np.concatenate([UV, centre]), np.concatenate([FACE_UV, [[0, 8, 9], [8, 9, 10]]]).astype(np.int32)
    move = np.zeros_like(uv)
    for right, expected in ((0.19, 1.0), (0.25, 6 / 8), (0.35, 4 / 8)):
        move[8] = right, 0
        kept, share = shortened_flow(uv, faces, move, size, size)
        # The chart reaches 0.2 to each side and its margin 3.5 pixels of 400 further: 0.20875 in eighths of the move.
        assert share[8] == expected
        np.testing.assert_allclose(kept[8], move[8] * expected)
    # Into the other chart there is no way back in: all that lies beyond the gap stays out.
    move[8] = 0.5, 0
    assert shortened_flow(uv, faces, move, size, size)[1][8] == 3 / 8


def test_what_moves_by_less_than_a_pixel_is_not_touched():
    move = np.full_like(UV, 0.2 / 400)
    np.testing.assert_array_equal(shortened_flow(UV, FACE_UV, move, 400, 400)[0], move)
