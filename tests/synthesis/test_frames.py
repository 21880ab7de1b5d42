from textured_pairs import ArrayCapture

from unstructured_mg.synthesis.frames import KeptFrames


def test_each_frame_is_read_once():
    capture = ArrayCapture(["first", "second"])
    kept = KeptFrames(capture)
    assert [kept.read(i) for i in (1, 0, 1, 1)] == ["second", "first", "second", "second"]
    assert capture.reads == [1, 0]
