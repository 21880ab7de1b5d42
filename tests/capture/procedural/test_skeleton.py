"""Bones: rotations against SciPy, legs that reach."""

import numpy as np
from scipy.spatial.transform import Rotation

from unstructured_mg.capture.procedural.skeleton import (
    INDEX,
    NAMES,
    PARENT,
    REST,
    chain,
    place_leg,
    rotation,
    swing,
    unit,
)

DRAW = np.random.default_rng(3)


def test_rotation_about_an_axis_agrees_with_scipy():
    axes, angles = unit(DRAW.normal(size=(20, 3))), DRAW.uniform(-3, 3, 20)
    assert np.abs(rotation(axes, angles) - Rotation.from_rotvec(axes * angles[:, None]).as_matrix()).max() < 1e-14


def test_swing_is_the_smallest_rotation_that_carries_start_to_end():
    start, end = unit(DRAW.normal(size=(50, 3))), unit(DRAW.normal(size=(50, 3)))
    turn = swing(start, end)
    assert np.abs((turn @ start[..., None])[..., 0] - end).max() < 1e-12
    angle = Rotation.from_matrix(turn).magnitude()
    assert np.abs(np.cos(angle) - np.sum(start * end, 1)).max() < 1e-12


def test_the_rest_pose_is_the_chain_without_rotations():
    rotations, positions = chain({}, REST[:1].repeat(2, 0))
    assert np.abs(positions - REST).max() < 1e-15
    assert np.abs(rotations - np.eye(3)).max() == 0


def test_the_skeleton_is_mirror_symmetric_and_parents_come_first():
    assert all(parent < joint for joint, parent in enumerate(PARENT))
    for name in NAMES:
        if name.startswith("left_"):
            twin = REST[INDEX[name.replace("left_", "right_")]]
            assert (twin == REST[INDEX[name]] * [-1, 1, 1]).all()


def test_a_leg_reaches_its_ankle_with_the_knee_towards_the_pole():
    frames = 30
    for side in ("left", "right"):
        hip, knee, ankle, toe = (INDEX[f"{side}_{part}"] for part in ("hip", "knee", "ankle", "toe"))
        rotations, positions = chain({}, REST[:1].repeat(frames, 0))
        goal = positions[:, hip] + [0, 0, -0.55] + DRAW.uniform(-0.25, 0.25, (frames, 3))
        foot = rotation(np.array([0.0, 0.0, 1.0]), DRAW.uniform(-1, 1, frames))
        pole = unit(foot @ np.array([0.0, -1.0, 0.0]))
        place_leg(rotations, positions, side, goal, foot, foot, pole)
        assert np.abs(positions[:, ankle] - goal).max() < 1e-12
        for upper, lower in ((hip, knee), (knee, ankle), (ankle, toe)):
            length = np.linalg.norm(REST[lower] - REST[upper])
            assert np.abs(np.linalg.norm(positions[:, lower] - positions[:, upper], axis=1) - length).max() < 1e-12
            turned = positions[:, upper] + rotations[:, upper] @ (REST[lower] - REST[upper])
            assert np.abs(turned - positions[:, lower]).max() < 1e-12
        middle = 0.5 * (positions[:, hip] + positions[:, ankle])
        assert (np.sum((positions[:, knee] - middle) * pole, 1) > 0).all()
        assert np.abs(np.linalg.det(rotations) - 1).max() < 1e-12
