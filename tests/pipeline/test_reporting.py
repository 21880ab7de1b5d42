import json
import shutil

import pytest
from small_build import quiet

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.reporting import make_report, report_data
from unstructured_mg.pipeline.work import open_work


def test_a_report_renders_what_is_missing_and_only_that(built, tmp_path):
    folder = tmp_path / "work"
    shutil.copytree(built.work, folder)
    page = make_report(folder, None, 2, quiet())
    assert page == folder / "report.html"
    first = page.read_bytes()
    sheets = sorted(folder.glob("pictures/*/sheet.jpg"))
    assert [sheet.parent.name for sheet in sheets] == sorted(path.name for path in folder.glob("transitions/*"))
    times = [sheet.stat().st_mtime_ns for sheet in sheets]
    sheets[0].write_bytes(b"damaged")
    other = make_report(folder, tmp_path / "again.html", 1, quiet())
    assert other.read_bytes() == first
    assert sheets[0].stat().st_mtime_ns != times[0]
    assert [sheet.stat().st_mtime_ns for sheet in sheets[1:]] == times[1:]
    assert not (folder / "scratch").exists()


def test_the_report_shows_what_the_work_folder_holds(built):
    work = open_work(built.work)
    data = report_data(work)
    graph = json.loads((built.work / "graph.json").read_text())
    assert [work.capture.frame_id(i) for i in data.covered.nonzero()[0]] == graph["frames"]
    assert data.visiting_after[data.covered].tolist() == graph["visits"]
    told = [(t["source"], t["target"], t["in_graph"], t["cost"], t["quality"]) for t in graph["transitions"]]
    name = work.capture.frame_id
    assert [(name(t.source), name(t.target), t.in_graph, t.cost, t.card) for t in data.transitions] == told
    assert [pair.status for pair in data.pairs] == [row["status"] for row in work.outcomes]


def test_a_place_that_holds_no_file_is_refused_before_anything_is_rendered(built, tmp_path):
    for place, fault in ((tmp_path, "is a folder"), (tmp_path / "nowhere" / "report.html", "there is no folder")):
        with pytest.raises(UserError, match=fault):
            make_report(built.work, place, 1, quiet())
    assert list(tmp_path.iterdir()) == []
