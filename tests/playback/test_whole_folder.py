import errno
import os

import pytest

from unstructured_mg.errors import UserError
from unstructured_mg.playback.whole_folder import whole_folder

OURS = r"frame_\d+\.obj"


def write(out, *names, force=False):
    with whole_folder(out, OURS, force) as folder:
        for name in names:
            (folder / name).write_text(name)


def listing(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_nothing_shows_before_the_end(tmp_path):
    out = tmp_path / "new" / "out"
    with whole_folder(out, OURS, False) as folder:
        (folder / "frame_1.obj").write_text("")
        assert not out.exists() and folder.parent == out.parent
    assert listing(tmp_path) == ["new/out/frame_1.obj"]
    assert out.stat().st_mode & 0o777 == (tmp_path / "new").stat().st_mode & 0o777


def test_an_empty_folder_is_free_and_a_full_one_is_not(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    write(out, "frame_1.obj")
    with pytest.raises(UserError, match="out: the folder is not empty: .* --force"):
        write(out, "frame_2.obj")
    assert listing(tmp_path) == ["out/frame_1.obj"]
    write(out, "frame_2.obj", "frame_3.obj", force=True)
    assert listing(tmp_path) == ["out/frame_2.obj", "out/frame_3.obj"]


def test_what_no_export_wrote_is_never_replaced(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(UserError, match=r"thesis.tex, which no export wrote"):
        write(tmp_path, "frame_1.obj", force=True)
    with pytest.raises(UserError, match=r"thesis.tex: this is a file"):
        write(tmp_path / "thesis.tex", "frame_1.obj", force=True)
    with pytest.raises(UserError, match=r"thesis.tex/out: the export failed"):
        write(tmp_path / "thesis.tex" / "out", "frame_1.obj")
    assert listing(tmp_path) == ["thesis.tex"]


def test_a_folder_that_filled_up_meanwhile_is_left_alone(tmp_path):
    out = tmp_path / "out"
    with pytest.raises(UserError, match="not empty"), whole_folder(out, OURS, False):
        out.mkdir()
        (out / "frame_9.obj").write_text("")
    assert listing(tmp_path) == ["out/frame_9.obj"] and len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OSError(errno.ENOSPC, "No space left on device"), "the disk is full, and nothing was kept: free some space"),
        (OSError(errno.EACCES, "Permission denied", "/captures/7.jpg"), "at /captures/7.jpg .Permission denied."),
    ],
)
def test_what_the_system_refuses_is_said_and_nothing_is_kept(tmp_path, error, said):
    with pytest.raises(UserError, match=said), whole_folder(tmp_path / "out", OURS, False) as folder:
        (folder / "frame_1.obj").write_text("")
        raise error
    assert list(tmp_path.iterdir()) == []


def test_an_earlier_export_comes_back_where_it_cannot_be_replaced(tmp_path, monkeypatch):
    out = tmp_path / "out"
    write(out, "frame_1.obj")
    rename = os.rename

    def refusing(source, target, **options):
        if "partial" in str(source):
            raise OSError(errno.EACCES, "Permission denied")
        rename(source, target, **options)

    monkeypatch.setattr(os, "rename", refusing)
    with pytest.raises(UserError, match="Permission denied"):
        write(out, "frame_2.obj", force=True)
    assert listing(tmp_path) == ["out/frame_1.obj"] and len(list(tmp_path.iterdir())) == 1
