import base64
import io
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from memory_capture import memory_capture
from PIL import Image

from unstructured_mg.errors import FrameFault
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.playback.pictures import Column, Picture, Seam, TransitionPictures
from unstructured_mg.playback.report import write_report
from unstructured_mg.playback.report_data import PairOutcome, ReportData, TransitionEntry
from unstructured_mg.synthesis.options import SynthesisOptions

NASTY = "x<script>\"&'y"
VOID = {"meta", "img", "input", "link", "br"}


class Page(HTMLParser):
    """The page's elements, with every open tag closed in order."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.elements, self.cells, self.text = [], [], [], ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)
        if tag in ("td", "th", "dd", "dt", "figcaption", "p", "h3", "h4"):
            self.cells.append("")

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "style" not in self.open:
            self.text += data
        if self.cells and any(tag in ("td", "th", "dd", "dt", "figcaption", "p", "h3", "h4") for tag in self.open):
            self.cells[-1] += data


def jpeg(level, width=30, height=10):
    data = io.BytesIO()
    Image.new("RGB", (width, height), (level, level, level)).save(data, "JPEG")
    return Picture(data.getvalue(), width, height)


def pictures_of(source, target):
    level = 100 + source
    return TransitionPictures(
        str(source),
        str(target),
        (Column("source", f"{NASTY}:2"), Column("step", "0"), Column("target", "9")),
        jpeg(level),
        Seam(jpeg(level + 1), ("frame 2", "step -1", "difference", "own"), 3.25, 3.125),
        Seam(jpeg(level + 2), ("step +1", "frame 9", "difference", "own"), 1.75, 1.625),
        jpeg(level + 3, 250),
        25,
        (3, 21),
        30.0,
    )


def report_data(**change):
    capture = memory_capture(
        [(NASTY, number) for number in range(40)] + [("other", number) for number in range(40)],
        faults=(FrameFault(NASTY, 40, f"{NASTY}/frame_40.obj", "is empty", "delete it"),),
        warnings=(f"fps of {NASTY} assumed",),
    )
    scores = np.abs(np.subtract.outer(np.arange(80.0), np.arange(80.0))).astype(np.float32)
    scores[:4] = scores[:, :4] = np.nan
    covered = np.zeros(80, bool)
    covered[8:60] = True
    kept, refused = Candidate(12, 55, 0.3125, 0.25, 10), Candidate(20, 70, 0.6875, -3.0, 10)
    card = {"volume_drift": 0.03125, "inverted_tets": 7, "texture": {"sharpness": 0.9375}}
    content = {
        "title": f"Motion graph of {NASTY}",
        "capture": capture,
        "capture_summary": (("folder", NASTY), ("clips", "2")),
        "scores": scores,
        "unit": "m",
        "threshold": 0.8125,
        "gap": 30,
        "candidates": (kept, refused),
        "nearest": (kept, refused),
        "pairs": (
            PairOutcome(kept, "kept"),
            PairOutcome(refused, "refused", "tracking", f"did not fit {NASTY}", {"hausdorff_m": 0.1875}),
        ),
        "transitions": (
            TransitionEntry(12, 55, 4, PlanarRigid(0.5, 3.0, 4.0), 0.3125, card, True),
            TransitionEntry(55, 12, 4, PlanarRigid(-0.5, 0.0, 0.0), 0.4375, {}, False),
        ),
        "covered": covered,
        "visiting_before": covered * np.linspace(1, 2, 80) / (covered * np.linspace(1, 2, 80)).sum(),
        "visiting_after": covered / 52.0,
        "stage_minutes": (("reading", 0.25), ("tracking <1>", 12.5)),
        "pictures": pictures_of,
        "pair_picture": lambda candidate: jpeg(candidate.source),
        "limits": SynthesisOptions(volume_drift=0.05, inverted_tets=0),
        "notes": (f"Frames of {NASTY} crowd.",),
        "version": "1.2.3",
    }
    return ReportData(**{**content, **change})


def written(tmp_path, **change):
    out = tmp_path / "report.html"
    write_report(report_data(**change), out)
    return out.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def text(tmp_path_factory):
    return written(tmp_path_factory.mktemp("report"))


def test_the_page_is_well_formed_and_needs_nothing_else(text):
    page = Page(text)
    assert [tag for tag, _ in page.elements if tag in ("script", "link", "iframe", "object")] == []
    for _, attributes in page.elements:
        for name in ("href", "src", "xlink:href"):
            value = attributes.get(name)
            assert value is None or value.startswith(("#", "data:image/"))
        assert not any(name.startswith("on") for name in attributes)
    assert not re.search(r"https?:|//[a-z]|@import|url\(", text.replace("url(#scale)", ""))


def test_every_link_and_label_has_its_target(text):
    page = Page(text)
    ids = [attributes["id"] for _, attributes in page.elements if "id" in attributes]
    assert len(ids) == len(set(ids))
    wanted = {attributes["href"][1:] for _, attributes in page.elements if attributes.get("href", "").startswith("#")}
    assert wanted <= set(ids)
    assert {"pair-12-55", "pair-20-70"} <= wanted


def test_names_are_text_and_never_markup(text):
    assert "<script" not in text and NASTY not in text
    page = Page(text)
    for sentence in (
        f"Motion graph of {NASTY}",
        f"fps of {NASTY} assumed",
        f"{NASTY}/frame_40.obj",
        f"did not fit {NASTY}",
        f"Frames of {NASTY} crowd.",
        f"Frames {NASTY}:12 and other:15",
        f"{NASTY}:2",
        "tracking <1>",
    ):
        assert sentence in page.text


def test_the_numbers_are_those_of_the_data(text):
    cells = Page(text).cells

    def after(name):
        return cells[cells.index(name) + 1]

    assert after("frames captured") == "80"
    assert after("frames in the graph") == "52 65 %"
    assert after("candidate pairs") == "2" and after("pairs refused") == "1" and after("pairs kept") == "1"
    assert after("minutes") == "12.8" and after("total") == "12.8"
    assert after("reading") == "0.25" and after("tracking <1>") == "12.5"
    assert after("transitions made") == "2" and after("transitions in the graph") == "1"
    row = cells.index("volume drift")
    assert cells[row : row + 8] == ["volume drift", "3.12 %", "5 %", "good", "cage cells inside out", "7", "0", "poor"]
    assert after("sharpness of the middle to the ends") == "0.938 ×"
    row = cells.index(f"Frames {NASTY}:20 and other:30")
    assert cells[row + 1 : row + 5] == [
        f"did not fit {NASTY}",
        "688 mm apart, turned by −171.9°; refused in tracking",
        "hausdorff",
        "188 mm",
    ]
    row = cells.index(f"{NASTY}:12 and other:15")
    assert cells[row + 1 : row + 4] == ["312 mm", "14.3°", "kept"]
    joined = "\n".join(cells)
    assert "312 mm apart, turned by 14.3°" in joined
    assert (
        f"leaves at frame {NASTY}:8, 7 synthesized frames, arrives at frame other:19; cost 0.3125; "
        "the target is turned by 28.6° and moved by 5 m"
    ) in joined
    assert "First seam: mean change of 3.25 levels of 255, in the capture 3.125" in joined
    share = np.linspace(1, 2, 80)[8:60]
    spread = np.abs(share / share.mean() - 1).mean()
    assert f"is {100 * spread:.3g} % with even choices and" in joined
    assert "pairs up to 812 mm are candidates" in joined


def test_every_pair_that_was_tried_can_be_copied_into_pairs_json(text):
    """What the page shows is what pairs.json takes: JSON, with the capture's own ids, however they are spelt."""
    shown = Page(text[text.index('<h2 id="choosing">') : text.index("<footer>")]).text
    capture = report_data().capture
    ids = [[capture.frame_id(i) for i in pair] for pair in ((12, 55), (20, 70))]
    lines = shown.splitlines()
    rows = [line[line.rindex('["') :] for line in lines if line.endswith((" kept", " refused"))]
    assert [json.loads(row.rpartition("  ")[0]) for row in rows] == ids
    example = next(line[line.index("{") :] for line in lines if '"pins"' in line)
    assert json.JSONDecoder().raw_decode(example)[0] == {"pins": [], "vetoes": [ids[0]]}


def test_pictures_are_embedded_as_they_are_and_loaded_late(text):
    images = [attributes for tag, attributes in Page(text).elements if tag == "img"]
    assert all(image["loading"] == "lazy" and image["alt"] for image in images)
    found = [base64.b64decode(image["src"].split(",")[1]) for image in images]
    expected = []
    for source, target in ((12, 55), (55, 12)):
        made = pictures_of(source, target)
        expected += [made.film.data, made.sheet.data, made.start.picture.data, made.end.picture.data]
    assert found == [*expected, jpeg(20).data]
    assert "--film:0.8333s;--frames:25" in text


def test_without_a_candidate_the_nearest_pairs_are_shown(tmp_path):
    text = written(
        tmp_path,
        candidates=(),
        pairs=(),
        transitions=(),
        covered=None,
        visiting_before=None,
        visiting_after=None,
        notes=(),
    )
    page = Page(text)
    row = page.cells.index(f"{NASTY}:12 and other:15")
    assert page.cells[row + 1 : row + 4] == ["312 mm", "14.3°", ""]
    assert "No pair comes within the threshold of 812 mm." in page.text
    row = page.cells.index(f"Frames {NASTY}:12 and other:15")
    assert page.cells[row + 1] == "312 mm apart, turned by 14.3°"
    assert base64.b64encode(jpeg(12).data).decode() in text and base64.b64encode(jpeg(20).data).decode() in text
    assert "no two windows are alike enough" in page.text
    assert "Transitions" not in page.text


def test_before_matching_there_is_still_a_report(tmp_path):
    nothing = dict.fromkeys(("candidates", "nearest", "pairs", "transitions", "stage_minutes", "notes"), ())
    text = written(tmp_path, scores=None, covered=None, visiting_before=None, visiting_after=None, **nothing)
    assert "There is no matching result yet." in Page(text).text


def test_the_same_data_give_the_same_bytes(text, tmp_path):
    assert written(tmp_path) == text


def test_a_report_that_fails_leaves_the_old_one_alone(tmp_path):
    out = tmp_path / "report.html"
    out.write_text("old")

    def fail(source, target):
        raise OSError("disk")

    with pytest.raises(OSError, match="disk"):
        write_report(replace(report_data(), pictures=fail), out)
    assert out.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]
