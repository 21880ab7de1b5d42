"""The demo's own part: which folder it takes. What it runs is tested where it lives."""

import pytest
from rich.console import Console

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline import demo


def test_a_folder_of_others_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("precious")
    with pytest.raises(UserError, match="holds other files than a demo's"):
        demo.run_demo(tmp_path, 1, Console(quiet=True))
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_capture_cut_short_is_made_anew_before_it_counts(tmp_path, monkeypatch):
    """Killed while it writes the capture, the demo must not build from a part of it."""
    folder = tmp_path / "demo"

    def killed(partial, **rest):
        partial.mkdir()
        (partial / "frame_0000.obj").touch()
        raise KeyboardInterrupt

    monkeypatch.setattr(demo, "write_procedural", killed)
    with pytest.raises(KeyboardInterrupt):
        demo.run_demo(folder, 1, Console(quiet=True))
    assert not (folder / "capture").exists()

    def whole(partial, **rest):
        assert not partial.exists()
        partial.mkdir()
        (partial / "frame_0001.obj").touch()

    def build(capture, work, options, workers, progress):
        assert [path.name for path in capture.iterdir()] == ["frame_0001.obj"]
        raise UserError("seen")

    monkeypatch.setattr(demo, "write_procedural", whole)
    monkeypatch.setattr(demo, "build", build)
    with pytest.raises(UserError, match="seen"):
        demo.run_demo(folder, 1, Console(quiet=True))
    assert [path.name for path in folder.iterdir()] == ["capture"]
