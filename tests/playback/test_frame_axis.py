import numpy as np
from memory_capture import memory_capture

from unstructured_mg.playback.frame_axis import frame_axis, frame_ticks


def test_frames_keep_their_distance_and_clips_and_gaps_open_up():
    names = [("a", n) for n in (1, 2, 3, 7, 8)] + [("b", n) for n in range(5)]
    axis = frame_axis(memory_capture(names), 100.0, 900.0)
    steps = np.diff(axis.x)
    inside = [0, 1, 3, 5, 6, 7, 8]
    np.testing.assert_allclose(steps[inside], axis.pitch)
    assert axis.pitch < steps[2] <= steps[4]
    np.testing.assert_allclose([axis.x[0] - axis.pitch / 2, axis.x[-1] + axis.pitch / 2], [100, 900])
    assert axis.runs == (range(0, 3), range(3, 5), range(5, 10))
    assert axis.clips == (("a", 0, 4), ("b", 5, 9))
    assert axis.ids[3] == "a:7"


def test_ticks_name_the_frames_above_them():
    capture = memory_capture([("a", 13 + n) for n in range(95)])
    text = "".join(frame_axis(capture, 0.0, 950.0).draw(50.0))
    for number in (20, 40, 100):
        x = 10 * (number - 13) + 5
        assert f'x="{x}" y="68" text-anchor="middle">{number}<' in text


def test_ticks_are_round_frame_numbers_and_every_clip_has_one():
    capture = memory_capture([("a", n) for n in range(95, 143) if n != 110] + [("b", 3), ("b", 4)])
    ticks = frame_ticks(capture)
    assert [number for _, number in ticks] == ["95", "100", "105", "115", "120", "125", "130", "135", "140", "3"]
    assert all(str(capture.frames[index].number) == number for index, number in ticks)
