import hashlib
import json

import pytest
from site_reader import read_site_file, read_site_json
from small_build import quiet

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.site import make_site, serve_site
from unstructured_mg.pipeline.work import open_work
from unstructured_mg.playback.site_options import SiteOptions

OPTIONS = SiteOptions(texture_size=32, decimate=600)


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def sites(built, tmp_path_factory):
    """The page of a small build, by one worker and by two."""
    folder = tmp_path_factory.mktemp("sites")
    for workers in (1, 2):
        make_site(open_work(built.work), folder / str(workers), OPTIONS, False, workers, quiet())
    return folder


def test_a_page_is_the_same_with_any_number_of_workers(sites):
    assert contents(sites / "1") == contents(sites / "2")


def test_a_page_holds_every_frame_and_every_transition_of_the_graph(sites, built):
    work, site = open_work(built.work), sites / "1"
    told = read_site_json(site)
    assert told["inputs"] == {"graph.json": hashlib.sha256((built.work / "graph.json").read_bytes()).hexdigest()}
    assert [frame["id"] for frame in told["frames"]] == [work.capture.frame_id(i) for i in range(len(work.capture))]
    for frame in told["frames"]:
        file = read_site_file((site / f"{frame['file']}.js").read_bytes())
        assert file.header["frame"] == frame["id"] and file.name == frame["file"]
        assert len(file.faces) <= 600 and max(file.images[0].shape) <= 32
    used = work.graph.links_used()
    assert used and [file is not None for file in told["files"]] == [i in used for i in range(len(work.graph.links))]
    for link, name in zip(work.graph.links, told["files"], strict=True):
        if name is not None:
            file = read_site_file((site / f"{name}.js").read_bytes())
            ids = [work.capture.frame_id(frame) for frame in (link.source, link.target)]
            assert file.header["transition"] == ids and len(file.positions) == 2 * link.k - 1
            assert len(file.faces) <= 600 and file.flow is not None and len(file.images) == 2
    assert len(list((site / "frames").iterdir())) == len(work.capture)
    assert len(list((site / "transitions").iterdir())) == len(used)
    assert [walk["seed"] for walk in json.loads((site / "walks.json").read_text())["walks"]][:2] == [0, 1]


def test_only_an_earlier_page_is_replaced_and_only_when_asked(sites, built, tmp_path):
    work, out = open_work(built.work), tmp_path / "site"
    out.mkdir()
    (out / "thesis.tex").write_text("precious")
    for force in (False, True):
        with pytest.raises(UserError, match="thesis.tex" if force else "not empty"):
            make_site(work, out, OPTIONS, force, 1, quiet())
    (out / "thesis.tex").unlink()
    (out / "site.js").write_text("an earlier page")
    with pytest.raises(UserError, match="--force"):
        make_site(work, out, OPTIONS, False, 1, quiet())
    assert (out / "site.js").read_text() == "an earlier page"
    assert [path.name for path in tmp_path.iterdir()] == ["site"]


def test_no_page_is_written_into_the_capture(built):
    with pytest.raises(UserError, match="inside the capture"):
        make_site(open_work(built.work), built.capture / "site", OPTIONS, True, 1, quiet())


def test_only_a_page_is_served(tmp_path):
    with pytest.raises(UserError, match="is not a page's folder.*umg web"):
        serve_site(tmp_path, 0)
