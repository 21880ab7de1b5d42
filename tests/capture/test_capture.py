import json
import pickle

import numpy as np
import pytest
from broken_captures import break_frames, write_frames

from unstructured_mg.capture.capture import Capture, FrameFile
from unstructured_mg.capture.placement import UP_AXES
from unstructured_mg.capture.reader import open_capture
from unstructured_mg.errors import UserError


def test_gaps_padding_and_clips_keep_their_numbers_and_order(tmp_path):
    write_frames(tmp_path / "take 10", [1, 2], pattern="f{}")
    write_frames(tmp_path / "take 2", [0, 1, 2, 4, 5, 9, 10, 11], pattern="frame_{}")
    capture = open_capture(tmp_path, fps=25)
    assert [capture.frame_id(i) for i in range(len(capture))] == [
        *(f"take 2:{number}" for number in (0, 1, 2, 4, 5, 9, 10, 11)),
        *("take 10:1", "take 10:2"),
    ]
    assert capture.runs() == [range(0, 3), range(3, 5), range(5, 8), range(8, 10)]
    np.testing.assert_array_equal(np.flatnonzero(capture.window_centres(1)), [1, 6])
    assert not capture.window_centres(2).any()
    assert capture.index_of("take 10:2") == 9 and capture.fps == 25 and not capture.faults
    with pytest.raises(UserError, match="take 2:3"):
        capture.index_of("take 2:3")


def test_one_clip_has_plain_numbers_as_ids(tmp_path):
    capture = open_capture(write_frames(tmp_path, [8, 9, 10]))
    assert [capture.frame_id(i) for i in range(3)] == ["8", "9", "10"]
    assert capture.index_of("0009") == 1


def test_a_capture_survives_json_and_pickle(tmp_path):
    break_frames(tmp_path)
    capture = open_capture(tmp_path)
    assert Capture.from_json(json.loads(json.dumps(capture.to_json()))) == capture
    assert pickle.loads(pickle.dumps(capture)) == capture


@pytest.mark.parametrize("up", UP_AXES)
def test_to_metres_takes_the_floor_to_zero_and_up_to_z(tmp_path, up):
    capture = Capture(tmp_path, (FrameFile(".", 1, tmp_path / "f1.obj"),), 30.0, 0.1, up, 7.0)
    direction = np.eye(3)["xyz".index(up[-1])] * (-1.0 if up[0] == "-" else 1.0)
    matrix = capture.to_metres()
    assert np.linalg.det(matrix[:3, :3]) == pytest.approx(0.1**3)
    for height in (7.0, 27.0):
        moved = matrix @ [*(height * direction), 1.0]
        assert moved[2] == pytest.approx(0.1 * (height - 7.0)) and moved[3] == 1.0
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, 0.01 * np.eye(3), atol=1e-15)


def test_ids_stay_the_same_when_all_frames_of_another_clip_are_bad(tmp_path):
    write_frames(tmp_path / "a", [1, 2])
    write_frames(tmp_path / "b", [1])
    (tmp_path / "b" / "frame_0001.obj").write_text("")
    capture = open_capture(tmp_path)
    assert [capture.frame_id(i) for i in range(2)] == ["a:1", "a:2"] and capture.clips == ("a", "b")
