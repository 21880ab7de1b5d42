import struct

import pytest
from sequence_samples import moved_body, vols_frame, vols_header

from unstructured_mg.capture.reader import open_capture
from unstructured_mg.errors import UserError

TAKE = vols_header(13, 3) + b"".join(vols_frame(13, i, moved_body(i), kind=int(i == 0)) for i in range(3))


def test_a_folder_of_takes_is_a_clip_each(tmp_path):
    for clip, rate in (("a", 25.0), ("b", 50.0)):
        (tmp_path / clip).mkdir()
        data = bytearray(TAKE)
        data[28:32] = struct.pack("<f", rate)
        (tmp_path / clip / "take.vols").write_bytes(data)
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "take.vols").write_bytes(TAKE[:30])
    capture = open_capture(tmp_path)
    assert capture.clips == ("a", "b", "c") and [frame.number for frame in capture.frames] == [0, 1, 2] * 2
    assert [fault.clip for fault in capture.faults] == ["c"] and "it ends at byte 30" in capture.faults[0].fault
    assert capture.fps == 25 and any("different rates" in warning for warning in capture.warnings)
    assert open_capture(tmp_path, fps=10).fps == 10


def test_two_takes_in_one_folder_are_refused(tmp_path):
    for name in ("a.vols", "b.vols"):
        (tmp_path / name).write_bytes(TAKE)
    with pytest.raises(
        UserError, match=r"b.vols, a.vols beside it is a whole capture too; give each a folder of its own"
    ):
        open_capture(tmp_path)


def test_other_programs_json_beside_frames_is_passed_over(tmp_path):
    (tmp_path / "take.vols").write_bytes(TAKE)
    (tmp_path / "notes.json").write_text('{"geometry of the room": [1, 2]}')
    (tmp_path / "broken.json").write_text("{")
    assert len(open_capture(tmp_path)) == 3
