import numpy as np
import pytest

from unstructured_mg.matching import fields
from unstructured_mg.matching.fields import Fields


def test_any_range_of_frames_is_read_back_across_files(tmp_path, monkeypatch):
    monkeypatch.setattr(fields, "BLOCK", 4)
    rng = np.random.default_rng(0)
    values = (rng.normal(size=(6, 10, 5)) + 1j * rng.normal(size=(6, 10, 5))).astype(np.complex64)
    stored = Fields(tmp_path, 10, 6, 5, np.complex64)
    assert [(b.start, b.stop) for b in stored.blocks()] == [(0, 4), (4, 8), (8, 10)]
    for block in stored.blocks():
        stored.write(block, np.ascontiguousarray(values[:, block.start : block.stop]))
    # Frames outside the capture are nought: windows that reach there are never asked for.
    padded = np.pad(values, ((0, 0), (3, 3), (0, 0)))
    for row in range(6):
        for start in range(-3, 10):
            for stop in range(max(start, 0) + 1, 14):
                np.testing.assert_array_equal(stored.read(row, start, stop), padded[row, start + 3 : stop + 3])
    stored.remove()
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_ends_too_early_is_named(tmp_path):
    stored = Fields(tmp_path, 2, 6, 5, np.complex64)
    stored.write(range(2), np.zeros((6, 1, 5), np.complex64))
    with pytest.raises(ValueError, match="fields_000000.bin: expected 80 bytes"):
        stored.read(5, 0, 2)
