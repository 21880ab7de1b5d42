"""Work folders that were damaged or made up, checksums and all: they are read, or what is wrong names the file."""

import hashlib
import json
import os
import random
import shutil

import numpy as np
import pytest
from inline_pool import InlinePool
from mutation import mutated
from small_build import quiet
from tiny_capture import TINY, write_tiny_capture

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline import build as build_module
from unstructured_mg.pipeline.build import build
from unstructured_mg.pipeline.choices import read_choices
from unstructured_mg.pipeline.status import work_status
from unstructured_mg.pipeline.work import open_work
from unstructured_mg.playback.stream import posed_frames
from unstructured_mg.playback.walk import random_walk
from unstructured_mg.tracking.cage import read_cage
from unstructured_mg.tracking.files import read_pair

CASES = int(os.environ.get("UMG_FUZZ_CASES", "15"))


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("finished")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build_module, "open_pool", lambda workers, address: InlinePool())
        build(write_tiny_capture(folder / "capture"), folder / "work", TINY, 1, quiet())
    return folder / "work"


def sign(work, file):
    """Give the manifest of the artefact that ``file`` is in the checksum of what is there now."""
    name = file.relative_to(work).as_posix()
    artefact = name if name.endswith(".json") and name.count("/") == 0 else "/".join(name.split("/")[:-1])
    path = work / "manifests" / f"{artefact}.json"
    manifest = json.loads(path.read_text())
    inside = "" if artefact == name else file.name
    manifest["files"][inside] = hashlib.sha256(file.read_bytes()).hexdigest()
    path.write_text(json.dumps(manifest))


def play(work):
    """Everything that a player reads of a work folder."""
    opened = open_work(work)
    assert len(opened.matching.candidates) >= 0 and opened.matching_options.k >= 0 and opened.synthesis_options.blend
    walk = random_walk(opened.graph, opened.capture, 30, 3)
    for frame in posed_frames(walk.frames, opened.capture, opened.load_transition):
        assert np.isfinite(frame.vertices).all()


KINDS = (
    "capture.json", "graph.json", "outcomes.json", "matching/matching.json", "matching/dissimilarity.npz",
    "transitions/*/geometry.npz", "transitions/*/flow.npz", "transitions/*/card.json", "manifests/graph.json.json",
    "manifests/outcomes.json.json", "manifests/transitions/*.json", "work.json", "timings.json",
)  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_whatever_the_bytes_a_work_folder_plays_or_its_fault_is_told(finished, tmp_path, kind):
    work = tmp_path / "work"
    shutil.copytree(finished, work)
    file = sorted(work.glob(kind))[0]
    data, draw = file.read_bytes(), random.Random(kind)
    manifests = {path: path.read_bytes() for path in (work / "manifests").rglob("*.json")}
    play(work)
    for case in range(CASES):
        file.write_bytes(mutated(data, draw))
        if kind.split("/")[0] not in ("manifests", "work.json", "timings.json"):
            sign(work, file)
        try:
            play(work)
            work_status(work)
        except UserError as error:
            assert str(error).startswith("/")  # the file
            # What capture.json says leads to other files, and a folder without good manifests has not been finished.
            assert kind == "capture.json" or "manifests" in kind or file.name in str(error)
        except Exception as error:
            kept = tmp_path / f"case {case}"
            kept.write_bytes(file.read_bytes())
            raise AssertionError(f"case {case} of {kind}, kept in {kept}") from error
        for path, content in manifests.items():
            path.write_bytes(content)


@pytest.mark.parametrize(
    "kind", ["cages/*/cage.npz", "cages/*/cage.json", "pairs/*/tracked.npz", "pairs/*/tracked.json"]
)
def test_whatever_the_bytes_what_workers_read_is_whole_or_its_fault_is_told(finished, tmp_path, kind):
    read = read_cage if kind.startswith("cages") else read_pair
    source = sorted(finished.glob(kind))[0]
    folder = tmp_path / source.parent.name
    shutil.copytree(source.parent, folder)
    data, draw = source.read_bytes(), random.Random(kind)
    for _ in range(CASES):
        (folder / source.name).write_bytes(mutated(data, draw))
        try:
            found = read(folder)
            tets = found.tets
            vertices = found.vertices if kind.startswith("cages") else found.cage_vertices[0]
            assert tets.size == 0 or 0 <= tets.min() <= tets.max() < len(vertices)
        except UserError as error:
            assert str(folder / source.name) in str(error)


def test_whatever_the_bytes_pairs_json_is_read_or_its_fault_is_told(finished, tmp_path):
    capture, path = open_work(finished).capture, tmp_path / "pairs.json"
    data, draw = b'{"pins": [["7", "17"], ["2", "12"]], "vetoes": [[3, 13]]}', random.Random(4)
    for _ in range(CASES):
        path.write_bytes(mutated(data, draw))
        try:
            read_choices(path, capture, None)
        except UserError as error:
            assert str(path) in str(error)
