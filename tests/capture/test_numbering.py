import pytest

from unstructured_mg.capture.numbering import frame_numbers, natural_key


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
