from broken_captures import break_frames, write_frames

from unstructured_mg.capture.inspect import inspect_capture
from unstructured_mg.capture.inspect_text import inspection_text
from unstructured_mg.capture.reader import open_capture


def test_text_names_every_fault_with_its_remedy(tmp_path):
    break_frames(tmp_path)
    inspection = inspect_capture(open_capture(tmp_path))
    text = inspection_text(inspection, width=400)
    for fault in inspection.faults:
        assert f"frame_{fault.number:04d}" in text and fault.fault in text and fault.remedy in text
    assert "18 good, 11 bad; 30 a second" in text and "missing 1-12" in text
    assert f"Note: {inspection.warnings[0]}." in text
    assert max(len(line) for line in inspection_text(inspection, width=90).splitlines()) <= 90


def test_text_of_a_sound_capture(tmp_path):
    text = inspection_text(inspect_capture(open_capture(write_frames(tmp_path, range(3)), fps=24)), width=200)
    for line in (
        "3 good, 0 bad; 24 a second, 0.1 s",
        "0 to 2, 3 frames, no gaps",
        "unit m, y up, floor at 0 of that unit",
        "connectivity  the same in every frame",
        "atlas         the same in every frame",
        "texture       8 x 8",
        "Every frame can be used.",
    ):
        assert line in text
    assert "non-manifold edges" in text.split("None: ")[1]  # what is absent everywhere is said once, not tabled
