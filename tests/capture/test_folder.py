import pytest

from unstructured_mg.capture.folder import list_frames
from unstructured_mg.errors import UserError


def touch(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("")


def test_the_folder_itself_and_the_folders_in_it_are_clips(tmp_path):
    for name in (
        "b10/f1.obj",
        "b9/f2.obj",
        "b9/f1.ply",
        "f7.obj",
        "f7.png",
        "notes/read me 1.txt",
        ".hidden/f1.obj",
        "b9/._f1.obj",
    ):
        touch(tmp_path / name)
    listing = list_frames(tmp_path)
    assert [(frame.clip, frame.number, frame.path.name) for frame in listing.frames] == [
        (".", 7, "f7.obj"),
        ("b9", 1, "f1.ply"),
        ("b9", 2, "f2.obj"),
        ("b10", 1, "f1.obj"),
    ]
    assert not listing.faults and not listing.warnings


def test_a_frame_in_two_formats_counts_once_in_the_usual_one(tmp_path):
    for name in ("f1.ply", "f2.ply", "f2.obj", "f3.ply"):
        touch(tmp_path / name)
    listing = list_frames(tmp_path)
    assert [frame.path.name for frame in listing.frames] == ["f1.ply", "f2.ply", "f3.ply"] and not listing.faults


def test_files_without_a_number_are_left_out_aloud(tmp_path):
    for name in ("f1.obj", "rest pose.obj"):
        touch(tmp_path / name)
    listing = list_frames(tmp_path)
    assert len(listing.frames) == 1 and "rest pose.obj" in listing.warnings[0]


def test_no_folder(tmp_path):
    touch(tmp_path / "file")
    for name in ("file", "nowhere"):
        with pytest.raises(UserError, match=f"{name}: there is no such folder; "):
            list_frames(tmp_path / name)
