import shutil
import subprocess
import sys

from unstructured_mg.capture.ffmpeg import find_ffmpeg


def test_the_systems_comes_before_the_packages(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: f"/somewhere/{name}")
    assert find_ffmpeg() == "/somewhere/ffmpeg"
    monkeypatch.setattr(shutil, "which", lambda name: None)
    found = find_ffmpeg()
    assert found is not None and b"ffmpeg version" in subprocess.run([found, "-version"], capture_output=True).stdout


def test_without_either_there_is_none(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert find_ffmpeg() is None
