import hashlib

import numpy as np
import pytest
from broken_captures import BODY_FACES, BODY_VERTICES, write_frames

from unstructured_mg.capture.capture import FrameFile
from unstructured_mg.capture.check import CheckedFrame, check_frames
from unstructured_mg.capture.obj_writer import write_obj
from unstructured_mg.errors import FrameFault


def test_hash_is_of_the_hashes_of_mesh_library_and_image(tmp_path):
    write_frames(tmp_path, [3])
    (checked,) = check_frames([FrameFile(".", 3, tmp_path / "frame_0003.obj")], tmp_path)
    parts = [
        hashlib.sha256((tmp_path / f"frame_0003{kind}").read_bytes()).digest() for kind in (".obj", ".mtl", ".png")
    ]
    assert checked.file.sha256 == hashlib.sha256(b"".join(parts)).hexdigest()
    assert checked.has_texture and not checked.has_colors


def test_debris_does_not_count_in_the_bounds(tmp_path):
    rng = np.random.default_rng(0)
    crumbs = rng.normal(size=(300, 3)) * 0.002 - [0, 0.8, 0]
    faces = np.vstack([BODY_FACES, np.arange(300).reshape(-1, 3) + len(BODY_VERTICES)]).astype(np.int32)
    write_obj(tmp_path / "f1.obj", np.vstack([BODY_VERTICES, crumbs]), faces, np.zeros((0, 2)), np.zeros((0, 3), int))
    (checked,) = check_frames([FrameFile(".", 1, tmp_path / "f1.obj")], tmp_path)
    assert isinstance(checked, CheckedFrame)
    assert checked.bounds.low[1] == pytest.approx(0.0, abs=1e-6)
    assert checked.bounds.high[1] == pytest.approx(1.7, abs=1e-6)


def test_a_bad_frame_is_a_fault_and_the_others_are_checked(tmp_path):
    write_frames(tmp_path, [1, 2, 3])
    (tmp_path / "frame_0002.obj").write_text("v 0 0 zero")
    files = [FrameFile(".", number, tmp_path / f"frame_{number:04d}.obj") for number in (1, 2, 3)]
    first, second, third = check_frames(files, tmp_path)
    assert isinstance(first, CheckedFrame) and isinstance(third, CheckedFrame)
    assert isinstance(second, FrameFault) and (second.clip, second.number) == (".", 2)
    assert second.file == str(files[1].path)
