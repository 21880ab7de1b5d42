"""The choreography: enough actions, repeats alike but not equal, smooth, and no foot that skates."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from unstructured_mg.capture.procedural.body import reference_body
from unstructured_mg.capture.procedural.motion import FPS, choreograph
from unstructured_mg.capture.procedural.skeleton import INDEX, NAMES
from unstructured_mg.capture.procedural.skin import pose

FRAMES = 300


@pytest.fixture(scope="module")
def motion():
    return choreograph(FRAMES, 0)


@pytest.fixture(scope="module")
def sample():
    """Every ninth vertex of the body and its weights."""
    body = reference_body()
    return body.vertices[::9], body.weights[::9]


@pytest.fixture(scope="module")
def track(motion, sample):
    return np.array([pose(*sample, motion.rotations[f], motion.positions[f]) for f in range(FRAMES)])


def in_own_place(points, motion, frame):
    """Points seen from the body: heading and floor place taken out."""
    c, s = np.cos(-motion.yaw[frame]), np.sin(-motion.yaw[frame])
    moved = points - motion.positions[frame, 0] * [1, 1, 0]
    return moved @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T


@pytest.mark.parametrize("frames, repeated", [(240, 2), (300, 3)])
def test_at_least_five_actions_some_of_them_repeated(frames, repeated):
    actions = choreograph(frames, 0).actions
    names = [action.name for action in actions]
    assert len(set(names)) >= 5
    assert sum(names.count(name) > 1 for name in set(names)) >= repeated
    assert actions[0].first == 0
    assert actions[-1].last == frames - 1
    assert all(after.first == before.last + 1 for before, after in zip(actions, actions[1:], strict=False))


def test_a_longer_motion_starts_like_a_shorter_one(motion):
    short = choreograph(120, 0)
    assert short.positions.tobytes() == motion.positions[:120].tobytes()
    assert short.rotations.tobytes() == motion.rotations[:120].tobytes()


def test_seeds_differ():
    assert np.abs(choreograph(120, 1).positions - choreograph(120, 0).positions).max() > 0.01


def test_velocity_is_continuous(track):
    """A kink would show as an acceleration of speed times frame rate: hands reach 6 m/s, so 180 m/s^2."""
    acceleration = np.linalg.norm(np.diff(track, 2, axis=0), axis=2) * FPS**2
    assert acceleration.max() < 100
    jerk = np.linalg.norm(np.diff(track, 3, axis=0), axis=2) * FPS**3
    assert jerk.max() < 2500
    # The trunk feels no more than about two and a half times gravity, on take-off and landing.
    trunk = reference_body().weights[::9, INDEX["chest"]] > 0.9
    assert acceleration[:, trunk].max() < 30


def test_planted_feet_neither_skate_nor_sink(motion):
    body = reference_body()
    for k, side in enumerate(("left", "right")):
        foot = body.weights[:, [INDEX[f"{side}_ankle"], INDEX[f"{side}_toe"]]].sum(1) > 0.99
        ball = foot & (body.vertices[:, 2] < 0.004) & (body.vertices[:, 1] < -0.12)
        assert ball.sum() >= 10
        feet = np.array(
            [
                pose(body.vertices[ball], body.weights[ball], motion.rotations[f], motion.positions[f])
                for f in range(FRAMES)
            ]
        )
        planted = motion.planted[:, k]
        assert planted.mean() > 0.6
        step = np.linalg.norm(np.diff(feet, axis=0), axis=2).max(1)
        assert step[planted[1:] & planted[:-1]].max() < 0.0025
        assert np.abs(feet[planted][..., 2]).max() < 0.006


def test_somebody_stands_on_the_floor_unless_he_jumps(motion, track):
    lowest = track[..., 2].min(1)
    assert lowest.min() > -0.004
    for action in motion.actions:
        if action.name != "jump":
            assert lowest[action.first : action.last + 1].max() < 0.012
        elif action.last - action.first > 25:
            assert lowest[action.first : action.last + 1].max() > 0.10


def test_the_feet_go_where_they_were_sent(motion):
    for side in ("left", "right"):
        hip, ankle = INDEX[f"{side}_hip"], INDEX[f"{side}_ankle"]
        for joint, below in ((ankle, INDEX[f"{side}_toe"]), (hip, INDEX[f"{side}_knee"])):
            length = np.linalg.norm(motion.positions[:, joint] - motion.positions[:, below], axis=1)
            assert np.ptp(length) < 1e-12


def test_hands_and_legs_stay_apart_from_the_body(track):
    weights = reference_body().weights[::9]
    part = np.array(NAMES)[weights.argmax(1)]
    hands = np.char.endswith(part, "wrist")
    rest = np.isin(
        part, [name for name in NAMES if name.split("_")[-1] in ("pelvis", "spine", "chest", "head", "hip", "knee")]
    )
    left, right = (np.isin(part, [f"{side}_{name}" for name in ("knee", "ankle", "toe")]) for side in ("left", "right"))
    for points in track[::3]:
        assert cKDTree(points[rest]).query(points[hands])[0].min() > 0.03
        assert cKDTree(points[left]).query(points[right])[0].min() > 0.03


def test_repeats_are_alike_and_not_equal_and_elsewhere(motion, track):
    complete = [action for action in motion.actions if action.last < FRAMES - 1]
    for name in ("wave", "squat"):
        first, second = [action for action in complete if action.name == name][:2]
        length = min(first.last - first.first, second.last - second.first) + 1
        gaps = []
        for i in range(length):
            one = in_own_place(track[first.first + i], motion, first.first + i)
            others = [in_own_place(track[f], motion, f) for f in range(second.first, second.last + 1)]
            gaps.append(min(np.sqrt(np.mean(np.sum((one - other) ** 2, 1))) for other in others))
        assert max(gaps) < 0.06
        assert np.mean(gaps) > 0.001
        turned = motion.yaw[second.first] - motion.yaw[first.first]
        assert abs(np.degrees(turned)) > 40
        assert np.linalg.norm((motion.positions[second.first] - motion.positions[first.first])[0, :2]) > 0.3


def test_every_stand_has_the_same_stance(motion):
    """After walking and turning the feet are again side by side: a stand matches every other stand."""
    feet = [INDEX[f"{side}_{part}"] for side in ("left", "right") for part in ("ankle", "toe")]
    middles = [(a.first + a.last) // 2 for a in motion.actions if a.name == "stand"]
    stances = []
    for frame in middles:
        places = motion.positions[frame, feet]
        centred = places - places.mean(0) * [1, 1, 0]
        c, s = np.cos(-motion.yaw[frame]), np.sin(-motion.yaw[frame])
        stances.append(centred @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T)
    assert np.ptp(stances, axis=0).max() < 0.004
