import json
import shutil

import numpy as np
from small_build import quiet

from unstructured_mg.capture.capture import Capture
from unstructured_mg.pipeline import preview
from unstructured_mg.pipeline.build import build
from unstructured_mg.pipeline.options import build_options
from unstructured_mg.pipeline.preview import preview_capture, preview_inputs, preview_options
from unstructured_mg.pipeline.work import open_work


def test_only_what_a_preview_is_not_for_is_changed():
    options = build_options(blend="poisson", window=4, max_pairs=2)
    seen = preview_options(options)
    assert seen.preview and (seen.matching.k, seen.synthesis.blend, seen.max_pairs) == (4, "poisson", 2)
    assert (seen.synthesis.texture, options.synthesis.texture) == ("crossfade", "flow")
    assert preview_options(build_options(texture="none")).synthesis.texture == "none"
    assert preview_inputs(options) == {} and preview_inputs(seen) == {"preview_faces": preview.FACES}


def test_a_preview_reads_fewer_triangles_finds_the_pair_and_can_be_walked(built, tmp_path, monkeypatch):
    monkeypatch.setattr(preview, "FACES", 1000)
    # Frames of 1500 triangles have a short work of their own: the pair's neighbourhood is enough.
    kept = next(row for row in open_work(built.work).outcomes if row["status"] == "kept")
    work = tmp_path / "work"
    shutil.copytree(built.work, work)
    (work / "pairs.json").write_text(json.dumps({"pins": [[kept["source"], kept["target"]]]}))
    build(built.capture, work, preview_options(built.options), 1, quiet())
    opened = open_work(work)
    assert [(row["source"], row["target"]) for row in opened.outcomes if row["status"] == "kept"] == [
        (kept["source"], kept["target"])
    ]
    full = open_work(built.work)
    for link in opened.graph.links:
        seen, whole = (each.load_transition(link.source, link.target) for each in (opened, full))
        assert len(seen.faces) < 0.8 * len(whole.faces)
        # The same motion: the middle frames' bounds agree within the triangles' size.
        for step in (0, len(seen.vertices) // 2, -1):
            for edge in (np.min, np.max):
                difference = edge(seen.vertices[step], axis=0) - edge(whole.vertices[step], axis=0)
                assert np.abs(difference).max() < 0.05
    # What is read for walks are the captured frames themselves.
    assert type(opened.capture) is Capture
    index = opened.graph.links[0].leaves
    assert len(opened.capture.read(index).faces) > 1400 > 1050 > len(preview_capture(opened.capture).read(index).faces)
