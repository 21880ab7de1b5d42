import io
import shutil

import pytest
from rich.console import Console
from work_contents import contents

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.lock import FolderLock
from unstructured_mg.pipeline.status import print_status, work_status
from unstructured_mg.pipeline.work import open_work


def text(status):
    console = Console(file=io.StringIO(), width=100)
    print_status(status, console)
    return console.file.getvalue()


def test_a_finished_build_is_counted_from_its_files_and_left_alone(built):
    before = contents(built.work)
    status = work_status(built.work)
    assert status.finished and status.holder is None and status.leftovers == 0
    assert (status.source, status.frames, status.faults) == (str(built.capture.resolve()), 100, 0)
    outcomes = open_work(built.work).outcomes
    stages = {stage.name: stage for stage in status.stages}
    refused = sum(row["refusal"] is not None and row["refusal"]["stage"] == "tracking" for row in outcomes)
    assert stages["pairs"].whole == len(list(built.work.glob("pairs/*"))) and stages["pairs"].refused == refused
    assert stages["transitions"].whole == len(list(built.work.glob("transitions/*")))
    assert all(stage.damaged == () for stage in status.stages)
    assert contents(built.work) == before
    assert "not finished" not in text(status)


def test_damage_leftovers_an_unfinished_build_and_its_writer_are_named(built, tmp_path):
    work = tmp_path / "work"
    shutil.copytree(built.work, work)
    victim = next(work.glob("transitions/*/geometry.npz"))
    victim.write_bytes(victim.read_bytes()[:-1])
    (work / "capture.json").write_text("{}")
    (work / "manifests" / "graph.json.json").unlink()
    (work / "scratch").mkdir()
    (work / "scratch" / "half").touch()
    status = work_status(work)
    assert not status.finished and status.frames is None and status.leftovers == 1
    damaged = {name for stage in status.stages for name in stage.damaged}
    assert damaged == {f"transitions/{victim.parent.name}", "capture.json"}
    shown = " ".join(text(status).split())
    assert f"transitions/{victim.parent.name} is damaged" in shown
    assert "not finished" in shown and "1 files were left" in shown
    with FolderLock(work):
        assert "being written now (process" in text(work_status(work))


def test_a_folder_of_others_is_none_of_ours(tmp_path):
    with pytest.raises(UserError, match="is not a work folder"):
        work_status(tmp_path)
