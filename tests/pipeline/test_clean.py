import shutil

import pytest
from small_build import quiet
from work_contents import contents

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.build import build
from unstructured_mg.pipeline.clean import clean
from unstructured_mg.pipeline.lock import FolderLock
from unstructured_mg.pipeline.reporting import make_report
from unstructured_mg.pipeline.work import open_work
from unstructured_mg.playback.walk import random_walk


def test_what_goes_is_made_again_and_what_stays_suffices(built, tmp_path):
    work = tmp_path / "work"
    shutil.copytree(built.work, work)
    make_report(work, None, 1, quiet())
    (work / "scratch").mkdir()
    (work / "scratch" / "half").write_bytes(b"1234")
    (work / "transitions" / "no manifest").mkdir()
    before = contents(work)
    tracked = [path.parent.name for path in work.glob("pairs/*/tracked.npz")]
    told = clean(work, dry_run=True)
    assert contents(work) == before and (work / "scratch" / "half").exists() and (work / "report.html").exists()

    total = sum(path.stat().st_size for path in work.rglob("*") if path.is_file())
    assert clean(work, dry_run=False) == told
    left = sum(path.stat().st_size for path in work.rglob("*") if path.is_file())
    manifests = total - left - sum(each.bytes for each in told)
    assert 0 < manifests < 50_000  # of what went
    assert [each.count for each in told] == [len(tracked), 2 + 1, 2]
    for name in ("pictures", "pairs"):
        assert list((work / name).glob("*/tracked.npz")) == list((work / name).glob("*/sheet.jpg")) == []
    assert not (work / "scratch").exists() and not (work / "report.html").exists()
    # What stays is as it was, and enough to walk; the next build has nothing to do.
    kept = contents(work)
    assert kept == {name: before[name] for name in kept}
    opened = open_work(work)
    link = opened.graph.links[0]
    assert random_walk(opened.graph, opened.capture, 50, 1) and opened.load_transition(link.source, link.target)
    times = {path: path.stat().st_mtime_ns for path in work.glob("*/*/*")}
    build(built.capture, work, built.options, 1, quiet())
    assert {path: path.stat().st_mtime_ns for path in work.glob("*/*/*")} == times
    assert [each.count for each in clean(work, dry_run=False)] == [0, 0, 0]


def test_only_work_folders_that_nobody_writes_are_cleaned(built, tmp_path):
    with pytest.raises(UserError, match="is not a work folder"):
        clean(tmp_path, dry_run=True)
    shutil.copytree(built.work, tmp_path / "work")
    with FolderLock(tmp_path / "work"), pytest.raises(UserError, match="another umg"):
        clean(tmp_path / "work", dry_run=False)
