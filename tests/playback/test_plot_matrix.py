import base64
import io
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from memory_capture import memory_capture
from PIL import Image

from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.playback.colormap import COLORS
from unstructured_mg.playback.plot_matrix import MARGIN, SIDE, plot_matrix
from unstructured_mg.playback.report_data import PairOutcome


def matrix_of(frames):
    scores = np.abs(np.subtract.outer(np.arange(frames), np.arange(frames))).astype(np.float32) / frames
    scores[:5] = scores[:, :5] = np.nan
    return scores


def parse(text):
    return ElementTree.fromstring(text)


def picture(svg):
    return Image.open(io.BytesIO(base64.b64decode(svg.find("image").get("href").split(",")[1])))


def test_every_pixel_has_the_colour_of_its_score():
    scores = matrix_of(40)
    image = picture(parse(plot_matrix(memory_capture([("a", n) for n in range(40)]), scores, "m", 0.2, 10, [])))
    highest = np.quantile(scores[np.isfinite(scores)], 0.99)
    pixels = np.asarray(image.convert("RGBA"))
    missing = np.isnan(scores)
    assert (pixels[missing][:, 3] == 0).all() and (pixels[~missing][:, 3] == 255).all()
    index = np.rint(255 * np.rint(254 * np.sqrt(np.clip(scores[~missing] / highest, 0, 1))) / 254).astype(int)
    assert (pixels[~missing][:, :3] == COLORS[index]).all()


def test_in_a_large_matrix_no_match_vanishes():
    scores = np.full((2000, 2000), 1.0, np.float32)
    scores[333, 1444] = 0.0
    image = np.asarray(
        picture(parse(plot_matrix(memory_capture([("a", n) for n in range(2000)]), scores, "m", 0.2, 10, [])))
    )
    assert max(image.shape) <= 900
    assert (image == 0).sum() == 1 and image[333 // 3, 1444 // 3] == 0


def test_pairs_are_marked_where_they_lie_and_link_to_the_report():
    pairs = [
        PairOutcome(Candidate(8, 30, 0.125, 0.0, 3), "kept"),
        PairOutcome(Candidate(10, 25, 0.5, 0.0, 3), "refused", "tracking", "too far & <away>"),
    ]
    svg = parse(plot_matrix(memory_capture([("a", n + 1) for n in range(40)]), matrix_of(40), "rad", 0.2, 10, pairs))
    ring = svg.find(".//circle[@class='kept']")
    assert float(ring.get("cx")) == pytest.approx(MARGIN + 30.5 * SIDE / 40, abs=0.01)
    assert float(ring.get("cy")) == pytest.approx(8 + 8.5 * SIDE / 40, abs=0.01)
    links = {link.get("href"): link.find("title").text for link in svg.iter("a")}
    assert links == {
        "#pair-8-30": "9 and 31: 7.16° apart, kept",
        "#pair-10-25": "11 and 26: 28.6° apart, refused: too far & <away>",
    }


def test_a_matrix_without_any_score_is_still_drawn():
    svg = parse(plot_matrix(memory_capture([("a", 0), ("a", 1)]), np.full((2, 2), np.nan), "m", 0.0, 60, []))
    assert np.asarray(picture(svg).convert("RGBA"))[..., 3].max() == 0
