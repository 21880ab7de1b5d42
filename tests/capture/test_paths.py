import os

import pytest

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.paths import capture_roots, decode_text, find_beside, find_named, read_regular_file


def test_names_are_found_below_and_beside_whatever_case_and_slashes(tmp_path):
    (tmp_path / "clip" / "Maps").mkdir(parents=True)
    (tmp_path / "shared").mkdir()
    frame = tmp_path / "clip" / "frame_1.obj"
    for path in (frame, tmp_path / "clip" / "Maps" / "A b.png", tmp_path / "shared" / "c.png"):
        path.write_text("x")
    roots = capture_roots(frame, tmp_path)
    assert find_named("maps\\a B.PNG", frame, roots) == tmp_path / "clip" / "Maps" / "A b.png"
    assert find_named("../shared/c.png", frame, roots).samefile(tmp_path / "shared" / "c.png")
    assert find_named(f"{tmp_path}/shared/c.png", frame, roots) == tmp_path / "shared" / "c.png"
    assert find_named("lost.png", frame, roots) is None and find_named("Maps", frame, roots) is None
    assert find_named("n" * 5000, frame, roots) is None
    assert find_beside(frame, (".mtl", ".png"), roots) is None


@pytest.mark.parametrize("name", ["../../x.png", "/etc/hostname", "d:/x.png", "..", "a\0b.png"])
def test_names_that_lead_outside_are_refused_whether_they_are_there_or_not(tmp_path, name):
    clip = tmp_path / "capture" / "clip"
    clip.mkdir(parents=True)
    frame = clip / "frame_1.obj"
    frame.write_text("x")
    with pytest.raises(FrameError, match="leads outside"):
        find_named(name, frame, capture_roots(frame, clip))


def test_links_that_lead_outside_are_refused_also_under_another_case_and_beside(tmp_path):
    folder = tmp_path / "capture"
    folder.mkdir()
    frame = folder / "frame_1.obj"
    frame.write_text("x")
    (tmp_path / "secret").write_text("x")
    (folder / "frame_1.png").symlink_to(tmp_path / "secret")
    (folder / "loop.png").symlink_to(folder / "loop.png")
    roots = capture_roots(frame, folder)
    for look in (
        lambda: find_named("FRAME_1.png", frame, roots),
        lambda: find_named("frame_1.png", frame, roots),
        lambda: find_beside(frame, (".png",), roots),
    ):
        with pytest.raises(FrameError, match="leads outside"):
            look()
    try:
        assert find_named("loop.png", frame, roots) is None
    except FrameError as error:  # Python's versions differ in whether a loop resolves
        assert "leads outside" in error.fault


def test_only_regular_files_of_bounded_size_are_read(tmp_path):
    (tmp_path / "a").write_bytes(b"abc")
    assert read_regular_file(tmp_path / "a") == b"abc"
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "empty").write_bytes(b"")
    with open(tmp_path / "huge", "wb") as stream:
        stream.truncate((1 << 28) + 1)
    for name, fault in (
        ("pipe", "not a regular file"),
        ("empty", "empty"),
        ("huge", "bytes"),
        ("lost", "no such file"),
        (".", "not a regular file"),
    ):
        with pytest.raises(FrameError, match=fault):
            read_regular_file(tmp_path / name)


def test_names_in_either_encoding():
    assert decode_text("Jörg.png".encode()) == decode_text("Jörg.png".encode("latin-1")) == "Jörg.png"
