import os

import pytest

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.stretch import read_stretch, whole_digest


def test_only_what_is_there_is_read(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(bytes(range(100)))
    assert read_stretch(path, 10, 5, "it") == bytes(range(10, 15))
    with pytest.raises(FrameError, match="it ends at byte 100, where the frame should reach from byte 90 to byte 101"):
        read_stretch(path, 90, 11, "the frame")
    with open(tmp_path / "sparse.bin", "wb") as file:
        file.truncate(1 << 33)
    with pytest.raises(FrameError, match="it at byte 0 takes 4294967296 bytes"):
        read_stretch(tmp_path / "sparse.bin", 0, 1 << 32, "it")
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FrameError, match="not a regular file"):
        read_stretch(tmp_path / "pipe", 0, 1, "it")


def test_a_digest_is_forgotten_when_the_file_changes(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(b"one")
    first = whole_digest(path)
    path.write_bytes(b"three")
    assert whole_digest(path) != first
