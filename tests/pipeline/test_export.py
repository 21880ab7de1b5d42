import hashlib
import json

import numpy as np
import pytest
import trimesh
from small_build import quiet

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.export import export_work
from unstructured_mg.pipeline.work import open_work
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.walk import random_walk


def test_a_walk_is_the_same_with_any_number_of_workers_and_names_its_graph(built, tmp_path):
    work = open_work(built.work)
    link = next(link for link in work.graph.links if work.graph.links.index(link) in work.graph.links_used())
    # Starts where the transition is the only way on, so that both kinds of frames come.
    walk = random_walk(work.graph, work.capture, 12, 5, link.leaves)
    for workers in (1, 2):
        export_work(work, walk, tmp_path / str(workers), ExportOptions(), False, workers, quiet())
    ours, theirs = ({p.name: p.read_bytes() for p in (tmp_path / str(n)).iterdir()} for n in (1, 2))
    assert ours == theirs
    told = json.loads(ours["walk.json"])
    assert told["inputs"] == {"graph.json": hashlib.sha256((built.work / "graph.json").read_bytes()).hexdigest()}
    kinds = [frame["source"] for frame in told["frames"]]
    steps = 2 * link.k - 1
    assert kinds == ["capture"] + ["transition"] * steps + ["capture"] * (11 - steps)
    # Before the transition W is the identity: the first frame is the captured one, vertex for vertex, byte for byte.
    first = work.capture.frames[link.leaves]
    captured, exported = (trimesh.load(p, process=False) for p in (built.capture / first.path.name,
                                                                   tmp_path / "1" / "frame_00001.obj"))  # fmt: skip
    np.testing.assert_allclose(captured.triangles, exported.triangles, atol=1e-6)
    assert ours["frame_00001.jpg"] == (built.capture / first.path.name).with_suffix(".jpg").read_bytes()


def test_nothing_is_exported_into_the_capture(built):
    work = open_work(built.work)
    walk = random_walk(work.graph, work.capture, 2, 0)
    with pytest.raises(UserError, match="inside the capture"):
        export_work(work, walk, built.capture / "walk", ExportOptions(), True, 1, quiet())
    assert not (built.capture / "walk").exists()
