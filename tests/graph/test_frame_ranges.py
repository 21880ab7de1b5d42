from toy_capture import toy_capture

from unstructured_mg.graph.frame_ranges import frame_ranges


def test_ranges_break_at_gaps_and_clips():
    capture = toy_capture(4, 3, 2, clips=True)
    assert frame_ranges(range(9), capture) == "a:1 to a:4, b:1 to b:3 and c:1 to c:2"
    assert frame_ranges([0, 1, 3], capture) == "a:1 to a:2 and a:4"
    assert frame_ranges([5], capture) == "b:2"


def test_the_middle_of_many_ranges_is_left_out():
    capture = toy_capture(4, 3, 2, clips=True)
    assert frame_ranges([0, 2, 5, 8], capture, most=2) == "a:1, ... and c:2"
