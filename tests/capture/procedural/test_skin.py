"""Dual-quaternion skinning: rigid where it must be, blended between."""

import numpy as np
from scipy.spatial.transform import Rotation

from unstructured_mg.capture.procedural.skeleton import INDEX, NAMES, REST
from unstructured_mg.capture.procedural.skin import pose, quaternions

DRAW = np.random.default_rng(5)


def test_quaternions_agree_with_scipy_up_to_sign():
    turns = Rotation.random(200, rng=DRAW)
    ours, theirs = quaternions(turns.as_matrix()), turns.as_quat(scalar_first=True)
    assert np.abs(np.abs(np.sum(ours * theirs, 1)) - 1).max() < 1e-12


def test_a_rigid_motion_of_all_bones_moves_every_vertex_rigidly():
    points = DRAW.normal(size=(100, 3))
    weights = DRAW.dirichlet(np.ones(len(NAMES)), 100)
    turn, shift = Rotation.from_rotvec([0.4, -2.0, 1.9]).as_matrix(), np.array([2.0, -1.0, 0.3])
    posed = pose(points, weights, np.repeat(turn[None], len(NAMES), 0), REST @ turn.T + shift)
    assert np.abs(posed - (points @ turn.T + shift)).max() < 1e-12


def test_a_vertex_of_one_bone_follows_that_bone():
    rotations = Rotation.from_rotvec(DRAW.normal(scale=0.4, size=(len(NAMES), 3))).as_matrix()
    positions = REST + DRAW.normal(scale=0.1, size=REST.shape)
    points = DRAW.normal(size=(len(NAMES), 3))
    posed = pose(points, np.eye(len(NAMES)), rotations, positions)
    expected = np.einsum("jab,jb->ja", rotations, points - REST) + positions
    assert np.abs(posed - expected).max() < 1e-12


def test_a_half_twisted_point_keeps_its_distance_from_the_axis():
    """Where linear blending would collapse: halfway between no turn and a turn of 170 degrees about the bone."""
    rotations = np.repeat(np.eye(3)[None], len(NAMES), 0)
    wrist = INDEX["left_wrist"]
    axis = np.array([0.0, 0.0, 1.0])
    rotations[wrist] = Rotation.from_rotvec(np.radians(170) * axis).as_matrix()
    weights = np.zeros((1, len(NAMES)))
    weights[0, [wrist, INDEX["left_elbow"]]] = 0.5
    point = REST[wrist] + [0.03, 0.0, 0.0]
    posed = pose(point[None], weights, rotations, REST)[0]
    assert abs(np.linalg.norm((posed - REST[wrist])[:2]) - 0.03) < 1e-12
