import os

import pytest

from unstructured_mg.playback.whole_file import whole_file


def test_the_old_file_stands_until_the_block_has_ended_well(tmp_path):
    path = tmp_path / "report.html"
    path.write_bytes(b"old")
    with pytest.raises(KeyboardInterrupt), whole_file(path) as stream:
        stream.write(b"half")
        raise KeyboardInterrupt
    assert path.read_bytes() == b"old"
    with whole_file(path) as stream:
        stream.write(b"new")
        assert path.read_bytes() == b"old"
    assert path.read_bytes() == b"new"
    assert [child.name for child in tmp_path.iterdir()] == ["report.html"]


@pytest.mark.parametrize("failing", ["fsync", "chmod", "replace"])
def test_no_failure_of_the_system_leaves_litter(tmp_path, monkeypatch, failing):
    def fail(*args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, failing, fail)
    with pytest.raises(OSError, match="No space left"), whole_file(tmp_path / "a.json") as stream:
        stream.write(b"{}")
    assert not list(tmp_path.iterdir())
