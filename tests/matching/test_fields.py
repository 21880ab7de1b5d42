import numpy as np
import pytest

from unstructured_mg.matching import fields
from unstructured_mg.matching.fields import Fields


def test_any_range_of_frames_is_read_back_across_files(tmp_path, monkeypatch):
    monkeypatch.setattr(fields, "BLOCK", 4)
    rng = np.random.default_rng(0)
    values = (rng.normal(size=(2, 3, 10, 5)) + 1j * rng.normal(size=(2, 3, 10, 5))).astype(np.complex64)
    stored = Fields(tmp_path, 10, 3, 5)
    assert [(b.start, b.stop) for b in stored.blocks()] == [(0, 4), (4, 8), (8, 10)]
    for block in stored.blocks():
        stored.write(block, np.ascontiguousarray(values[:, :, block.start : block.stop]))
    for field in (0, 1):
        for frequency in range(3):
            for start in range(10):
                for stop in range(start + 1, 11):
                    read = stored.read(field, frequency, start, stop)
                    np.testing.assert_array_equal(read, values[field, frequency, start:stop])
    stored.remove()
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_ends_too_early_is_named(tmp_path):
    stored = Fields(tmp_path, 2, 3, 5)
    stored.write(range(2), np.zeros((2, 3, 1, 5), np.complex64))
    with pytest.raises(ValueError, match="fields_000000.complex64: expected 80 bytes"):
        stored.read(1, 2, 0, 2)
