import numpy as np
import pytest
from toy_capture import toy_capture

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.requests import path_request, read_curve, read_poses

CAPTURE = toy_capture(10, 20, clips=True)
NOTHING = dict.fromkeys(("start", "goal", "frames", "seconds", "distance", "curve", "poses", "within"))


def asked(**given):
    return path_request(CAPTURE, **{**NOTHING, "loop": False, **given})


def test_words_become_indices_and_frames():
    found = asked(start="a:2", goal="b:5", seconds=1.5, distance=2.0)
    assert (found.start, found.goal, found.frames, found.distance) == (1, 14, 45, 2.0)
    with pytest.raises(UserError, match="--frames and --seconds"):
        asked(start="a:2", goal="b:5", seconds=1.5, frames=3)
    with pytest.raises(UserError, match='no usable frame "c:1"'):
        asked(start="c:1")


def test_curves_are_read_with_blanks_commas_and_remarks(tmp_path):
    path = tmp_path / "curve.txt"
    path.write_text("# x y\n0 0\n1.5, -2e-1   # a corner\n\n3\t4\n")
    np.testing.assert_array_equal(read_curve(path), [[0, 0], [1.5, -0.2], [3, 4]])
    assert asked(curve=path).curve.shape == (3, 2)


def test_poses_are_read_by_frame_id(tmp_path):
    path = tmp_path / "poses.txt"
    path.write_text("0 a:1\n2.5, b:20\n")
    assert read_poses(path, CAPTURE) == ((0.0, 0), (2.5, 29))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0 0\n1 2 3\n", "line 2"),
        ("0 0\n1 nan\n", "line 2"),
        ("one two\n", "line 1"),
        ("1 2\n", "holds 1 points"),
        ("", "holds 0 points"),
    ],
)
def test_a_curve_that_is_no_good_is_said_where(tmp_path, text, words):
    path = tmp_path / "curve.txt"
    path.write_text(text)
    with pytest.raises(UserError, match=words):
        read_curve(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0 a:1\n1\n", "line 2"),
        ("-1 a:1\n1 a:2\n", "line 1"),
        ("0 a:1\n1 z:2\n", "no usable frame"),
        ("0 a:1\n", "holds 1 poses"),
        ("3 a:1\n1 a:2\n", "1 seconds come after 3"),
    ],
)
def test_poses_that_are_no_good_are_said_where(tmp_path, text, words):
    path = tmp_path / "poses.txt"
    path.write_text(text)
    with pytest.raises(UserError, match=words):
        read_poses(path, CAPTURE)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(UserError, match=r"nothing\.txt"):
        read_curve(tmp_path / "nothing.txt")
