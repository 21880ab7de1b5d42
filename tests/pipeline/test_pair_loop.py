"""The loop's own rules, with tasks that do next to nothing in place of tracking and synthesis."""

import json
import os
import tempfile
from pathlib import Path

import pytest
from toy_capture import toy_capture

from unstructured_mg.errors import Refusal
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.pipeline import tasks
from unstructured_mg.pipeline.options import BuildOptions
from unstructured_mg.pipeline.pair_loop import PairLoop
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.store import Store

CAPTURE = toy_capture(200)
CANDIDATES = tuple(Candidate(s, t, 0.01 * n, 0.0, 10) for n, (s, t) in enumerate([(20, 100), (45, 130), (70, 160)]))


def made(scratch, count, **files):
    folders = tuple(Path(tempfile.mkdtemp(dir=scratch)) for _ in range(count))
    for folder in folders:
        for name, text in files.items():
            (folder / f"{name}.json").write_text(text)
    return tasks.TaskResult(folders, None, 0.0)


def prepare(capture, candidate, options, scratch):
    return made(scratch, 1, template=json.dumps({"template": capture.frame_id(candidate.source)}))


def track(capture, candidate, cage, options, scratch):
    if candidate.source == 45:
        return tasks._attempt("tracking", scratch, 1, lambda folders: Refusal("tracking", "too far", {"metres": 0.2}))
    return made(scratch, 1, tracked="{}")


def synthesise(capture, pair, options, scratch):
    return made(scratch, 2, card="{}")


def failing_track(capture, candidate, cage, options, scratch):
    if candidate.source == 45:
        return tasks._attempt("tracking", scratch, 1, lambda folders: [][1])
    return made(scratch, 1, tracked="{}")


def dying_track(capture, candidate, cage, options, scratch):
    if candidate.source == 45:
        os._exit(9)
    return made(scratch, 1, tracked="{}")


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.setattr(tasks, "prepare", prepare)
    monkeypatch.setattr(tasks, "synthesise", synthesise)
    store = Store(tmp_path / "work")
    store.create()
    store.clear_scratch()

    def run_with(task):
        monkeypatch.setattr(tasks, "track", task)
        with Pool(2) as pool:
            loop = PairLoop(store, pool, CAPTURE, BuildOptions(), {})
            outcomes = loop.run(CANDIDATES, lambda done, total: None)
        return store, {o.candidate.source: o.refusal for o in outcomes}

    return run_with


def test_kept_pairs_have_all_artefacts_and_a_refusal_is_stored_with_its_numbers(run):
    store, refusals = run(track)
    assert refusals == {20: None, 45: Refusal("tracking", "too far", {"metres": 0.2}), 70: None}
    assert store.names("pairs") == ["pairs/21-101", "pairs/46-131", "pairs/71-161"]
    assert store.names("transitions") == [f"transitions/{n}" for n in ("101-21", "161-71", "21-101", "71-161")]
    # A stored refusal is not tried again: a task that would fail now is never called.
    assert run(failing_track)[1] == refusals


def test_a_defect_refuses_one_pair_keeps_its_traceback_and_is_tried_again(run):
    store, refusals = run(failing_track)
    assert refusals[20] is None and refusals[70] is None
    assert "IndexError" in refusals[45].reason
    assert "IndexError" in (store.root / "tracebacks" / "46-131.txt").read_text()
    assert store.names("pairs") == ["pairs/21-101", "pairs/71-161"]
    _, refusals = run(track)
    assert refusals[45].reason == "too far"
    assert not (store.root / "tracebacks").exists()


def test_a_worker_that_dies_costs_only_its_own_pair(run):
    _, refusals = run(dying_track)
    assert refusals[20] is None and refusals[70] is None
    assert "died twice" in refusals[45].reason
