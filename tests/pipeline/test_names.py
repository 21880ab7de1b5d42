from toy_capture import toy_capture

from unstructured_mg.pipeline.names import frame_name, pair_name


def test_names_are_ids_that_every_file_system_takes():
    capture = toy_capture(3, 3, clips=True)
    assert [capture.frame_id(i) for i in (0, 5)] == ["a:1", "b:3"]
    assert frame_name(capture, 5) == "b_3"
    assert pair_name(capture, 0, 5) == "pairs/a_1-b_3"
    assert pair_name(capture, 5, 0, "transitions") == "transitions/b_3-a_1"


def test_every_pair_has_a_name_of_its_own():
    capture = toy_capture(12, 12, clips=True)
    names = {pair_name(capture, s, t) for s in range(24) for t in range(24)}
    assert len(names) == 24 * 24
