from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from broken_captures import BODY_FACES, BODY_VERTICES, break_frames, write_frames
from PIL import Image
from real_captures import real_capture

from unstructured_mg.capture.capture import frame_hash
from unstructured_mg.capture.reader import open_capture
from unstructured_mg.errors import UserError


def test_read_turns_to_metres_z_up_and_floor_zero(tmp_path):
    centimetres = (BODY_VERTICES + [3.0, 0.5, -1.0]) * 100
    capture = open_capture(write_frames(tmp_path, [1, 2, 3], vertices=centimetres))
    assert (capture.unit, capture.up) == (0.01, "y")
    mesh = capture.read(1)
    expected = np.column_stack([BODY_VERTICES[:, 0] + 3, 1.0 - BODY_VERTICES[:, 2], BODY_VERTICES[:, 1]])
    np.testing.assert_allclose(mesh.vertices, expected, atol=1e-6)
    np.testing.assert_array_equal(mesh.faces, BODY_FACES)
    np.testing.assert_array_equal(mesh.textures[0].pixels(), np.full((8, 8, 3), [2, 100, 50]))


def test_given_placement_wins_over_the_sidecar_and_the_sidecar_over_the_guess(tmp_path):
    write_frames(tmp_path, [1, 2])
    (tmp_path / "capture.json").write_text('{"fps": 50, "unit": "cm", "up": "-z", "floor": 7, "actor": "nobody"}')
    capture = open_capture(tmp_path)
    assert (capture.fps, capture.unit, capture.up, capture.floor) == (50, 0.01, "-z", 7)
    capture = open_capture(tmp_path, fps=24, unit=0.5, up="x", floor=-1)
    assert (capture.fps, capture.unit, capture.up, capture.floor) == (24, 0.5, "x", -1)
    (tmp_path / "capture.json").write_text('{"fps": "fast"}')
    with pytest.raises(UserError, match=r"capture\.json: fps is 'fast'"):
        open_capture(tmp_path)
    (tmp_path / "capture.json").unlink()
    with pytest.raises(UserError, match="unit is 'mile'"):
        open_capture(tmp_path, fps=3, unit="mile")


def test_every_bad_frame_is_a_fault_with_file_and_remedy_and_leaves_a_gap(tmp_path):
    expected = break_frames(tmp_path)
    capture = open_capture(tmp_path)
    assert [fault.number for fault in capture.faults] == sorted(expected)
    for fault in capture.faults:
        assert expected[fault.number] in fault.fault
        assert f"frame_{fault.number:04d}" in fault.file and len(fault.remedy) > 10
    assert capture.runs() == [range(0, 1), range(1, 18)]
    assert [frame.number for frame in capture.frames] == [0, *range(13, 30)]


def test_the_result_does_not_depend_on_the_number_of_workers(tmp_path):
    break_frames(tmp_path)
    calls = []
    alone = open_capture(tmp_path, progress=lambda done, total: calls.append((done, total)))
    with ProcessPoolExecutor(2) as executor:
        assert open_capture(tmp_path, executor=executor) == alone
    assert calls[-1] == (29, 29) and calls == sorted(calls)


def test_nothing_to_build_is_one_sentence(tmp_path):
    for folder in (tmp_path / "nowhere", tmp_path):
        with pytest.raises(UserError, match=str(folder)) as error:
            open_capture(folder)
        assert "\n" not in str(error.value) and str(error.value).endswith(".")
    (tmp_path / "template.obj").write_text("v 0 0 0")
    with pytest.raises(UserError, match="no frames"):
        open_capture(tmp_path)
    (tmp_path / "frame_1.obj").write_text("v 0 0 0")
    with pytest.raises(UserError, match="not one of its 1 frames can be used: of .*frame_1.obj, it holds no faces; "):
        open_capture(tmp_path)


def test_geometry_alone_is_a_capture_with_a_warning(tmp_path):
    capture = open_capture(write_frames(tmp_path, [1, 2], texture=False), fps=30)
    assert len(capture) == 2 and not capture.faults and len(capture.warnings) == 1
    assert "no texture" in capture.warnings[0]


def test_two_files_with_one_number(tmp_path):
    write_frames(tmp_path, [1, 2])
    write_frames(tmp_path, [2], pattern="frame_{}")
    capture = open_capture(tmp_path)
    assert len(capture) == 2 and [fault.fault for fault in capture.faults] == [
        "frame 2 is already there as frame_0002.obj"
    ]


def test_frame_hash_depends_on_every_file_of_the_frame_and_on_nothing_else(tmp_path):
    first = open_capture(write_frames(tmp_path / "a", [1, 2]))
    again = open_capture(write_frames(tmp_path / "b", [1, 2]))
    assert frame_hash(first, 0) == frame_hash(again, 0) != frame_hash(first, 1)
    seen = {frame_hash(first, 0)}
    for suffix in (".obj", ".mtl"):
        path = tmp_path / "a" / f"frame_0001{suffix}"
        path.write_text(path.read_text() + "# touched\n")
        seen.add(frame_hash(open_capture(tmp_path / "a"), 0))
    Image.new("RGB", (8, 8)).save(tmp_path / "a" / "frame_0001.png")
    seen.add(frame_hash(open_capture(tmp_path / "a"), 0))
    assert len(seen) == 4


def test_a_file_that_went_bad_since_is_a_user_error(tmp_path):
    capture = open_capture(write_frames(tmp_path, [1, 2]))
    capture.frames[1].path.write_text("v 1 2 3")
    with pytest.raises(UserError, match="frame_0002.obj: it holds no faces"):
        capture.read(1)


def test_real_captures_open_whole_and_stand_on_the_floor():
    for name in ("liam", "tetavi_walk"):
        capture = open_capture(real_capture(name, "0:4"))
        assert len(capture) == 4 and not capture.faults
        assert (capture.unit, capture.up) == (1.0, "y") and abs(capture.floor) < 0.03
        mesh = capture.read(2)
        assert mesh.textures[0].pixels().shape == (1024, 1024, 3)
        assert abs(np.quantile(mesh.vertices[:, 2], 0.01)) < 0.04 and 1.6 < mesh.vertices[:, 2].max() < 1.95
