import pytest

from unstructured_mg.capture.folder import frame_numbers, list_frames, natural_key
from unstructured_mg.errors import UserError


@pytest.mark.parametrize(
    "names, numbers",
    [
        (["f1.obj", "f2.obj", "f10.obj"], [1, 2, 10]),
        (["frame_0000.obj", "frame_0001.obj"], [0, 1]),
        (["take3_0007_10k.obj", "take3_0008_10k.obj", "take3_0009_10k.obj"], [7, 8, 9]),
        (["0001.obj", "0002.ply"], [1, 2]),
        (["actor2_00001.obj"], [1]),
        (["2024-05-01_17.obj", "2024-05-01_18.obj"], [17, 18]),
        (["Frame_01.OBJ", "frame_02.obj"], [1, 2]),
        (["template.obj"], []),
    ],
)
def test_the_number_is_what_varies(names, numbers):
    assert list(frame_numbers(names).values()) == numbers


def test_names_sort_by_their_numbers():
    names = ["take10", "take2", "Take1", "take", "take2b"]
    assert sorted(names, key=natural_key) == ["Take1", "take", "take2", "take2b", "take10"]


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
    frames, faults, warnings = list_frames(tmp_path)
    assert [(frame.clip, frame.number, frame.path.name) for frame in frames] == [
        (".", 7, "f7.obj"),
        ("b9", 1, "f1.ply"),
        ("b9", 2, "f2.obj"),
        ("b10", 1, "f1.obj"),
    ]
    assert not faults and not warnings


def test_a_frame_in_two_formats_counts_once_in_the_usual_one(tmp_path):
    for name in ("f1.ply", "f2.ply", "f2.obj", "f3.ply"):
        touch(tmp_path / name)
    frames, faults, _ = list_frames(tmp_path)
    assert [frame.path.name for frame in frames] == ["f1.ply", "f2.ply", "f3.ply"] and not faults


def test_files_without_a_number_are_left_out_aloud(tmp_path):
    for name in ("f1.obj", "rest pose.obj"):
        touch(tmp_path / name)
    frames, _, warnings = list_frames(tmp_path)
    assert len(frames) == 1 and "rest pose.obj" in warnings[0]


def test_no_folder(tmp_path):
    touch(tmp_path / "file")
    for name in ("file", "nowhere"):
        with pytest.raises(UserError, match=f"{name}: there is no such folder; "):
            list_frames(tmp_path / name)
