import json
import shutil

import pytest

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.work import open_work


def test_the_work_folder_says_how_it_was_built(built):
    work = open_work(built.work)
    assert work.matching_options == built.options.matching
    assert work.synthesis_options == built.options.synthesis
    assert len(work.capture) == 100
    assert [frame.number for frame in work.capture.frames] == list(range(100))


def test_what_is_damaged_is_never_read(built, tmp_path):
    folder = tmp_path / "work"
    shutil.copytree(built.work, folder)
    link = open_work(folder).graph.links[0]
    for file in folder.glob("transitions/*/geometry.npz"):
        file.write_bytes(file.read_bytes()[:-1])
    with pytest.raises(UserError, match="transitions/.* is missing or damaged; run umg build again"):
        open_work(folder).load_transition(link.source, link.target)
    graph = json.loads((folder / "graph.json").read_text())
    (folder / "graph.json").write_text(json.dumps({**graph, "fps": 15}))
    with pytest.raises(UserError, match=r"graph.json: is missing or damaged"):
        _ = open_work(folder).graph


@pytest.mark.parametrize("missing", ["manifests/graph.json.json", "capture.json"])
def test_an_unfinished_build_is_no_work_to_open(built, tmp_path, missing):
    folder = tmp_path / "work"
    shutil.copytree(built.work, folder)
    (folder / missing).unlink()
    with pytest.raises(UserError, match="its build has not finished"):
        open_work(folder)
    with pytest.raises(UserError, match="is not a work folder"):
        open_work(tmp_path)
