"""The whole road on a small procedural capture."""

import io
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from rich.console import Console
from small_build import quiet
from work_contents import contents

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.build import build
from unstructured_mg.pipeline.lock import FolderLock
from unstructured_mg.pipeline.options import build_options
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.work import open_work


def test_one_worker_makes_the_same_bytes_as_two(built, tmp_path):
    build(built.capture, tmp_path / "work", built.options, 1, quiet())
    ours, theirs = contents(built.work), contents(tmp_path / "work")
    assert ours.keys() == theirs.keys()
    assert [name for name in ours if ours[name] != theirs[name]] == []


def test_a_pair_is_kept_and_closes_a_loop(built):
    work = open_work(built.work)
    kept = [row for row in work.outcomes if row["status"] == "kept"]
    assert len(kept) == 1
    assert work.graph.cyclic
    source, target = (work.capture.index_of(kept[0][key]) for key in ("source", "target"))
    k = built.options.matching.k
    # Back from the later window to the earlier one: everything between is in the loop.
    np.testing.assert_array_equal(work.graph.frames, np.arange(source + k, target - k + 1))
    tracked = np.load(built.work / "pairs" / f"{kept[0]['source']}-{kept[0]['target']}" / "tracked.npz")
    assert tracked["vertices"].shape[0] == 4 * k + 2
    assert tracked["faces"].shape[1] == 3 and tracked["faces"].max() < tracked["vertices"].shape[1]


def test_seams_are_no_larger_than_the_captures_own_steps(built):
    """Across both seams of both transitions the surface moves no further than between captured frames there."""
    work = open_work(built.work)
    k = built.options.matching.k
    for link in work.graph.links:
        transition = work.load_transition(link.source, link.target)
        before, first = work.capture.read(link.leaves), transition.vertices[0]
        last, after = transition.vertices[-1], work.capture.read(link.arrives)
        for captured, vertices in (
            (before.vertices, first),
            (link.alignment.apply(after.vertices), last),
        ):
            distance = trimesh.proximity.closest_point(trimesh.Trimesh(vertices, transition.faces), captured)[1]
            assert np.sqrt(np.mean(distance**2)) < 0.01
        assert len(transition.textures) == 2 * k - 1


def test_what_is_damaged_or_missing_is_made_again_and_nothing_else(built, tmp_path):
    work = tmp_path / "work"
    shutil.copytree(built.work, work)
    expected = contents(work)
    victim = next(work.glob("transitions/*/geometry.npz"))
    victim.write_bytes(victim.read_bytes()[:-100])
    shutil.rmtree(work / "matching")
    (work / "manifests" / "graph.json.json").unlink()
    (work / "scratch").mkdir()
    (work / "scratch" / "left by a kill").touch()
    untouched = {path: path.stat().st_mtime_ns for path in work.glob("[cp]a*/*/*.npz")}
    out = io.StringIO()
    # One worker, which never runs ahead on a pair that is not needed.
    build(built.capture, work, built.options, 1, StageProgress(Console(file=out, width=500), explain=True))
    told = out.getvalue()
    assert f"{victim.parent.relative_to(work)} was damaged and has been made again" in told
    # --why names what is made, its reason, and nothing else: both ways of a pair are made together.
    reasons = [line for line in told.splitlines() if line.endswith((" is damaged", " is gone", " made yet"))]
    assert reasons == ["matching is gone", f"transitions/{victim.parent.name} is damaged"]
    assert contents(work) == expected
    assert {path: path.stat().st_mtime_ns for path in untouched} == untouched


def test_a_changed_option_reuses_what_it_does_not_touch(built, tmp_path):
    work = tmp_path / "work"
    shutil.copytree(built.work, work)
    tracked = next(work.glob("pairs/*/tracked.npz"))
    before = tracked.stat().st_mtime_ns
    options = replace(built.options, synthesis=build_options(blend="linear", texture="crossfade").synthesis)
    build(built.capture, work, options, 2, quiet())
    assert tracked.stat().st_mtime_ns == before
    kept = contents(work)
    assert {name for name, data in contents(built.work).items() if kept.get(name) != data} >= {
        path.relative_to(work).as_posix() for path in work.glob("transitions/*/geometry.npz")
    }


def test_bad_frames_are_listed_and_no_window_touches_them(built, tmp_path):
    bad = tmp_path / "capture"
    shutil.copytree(built.capture, bad)
    (bad / "frame_0002.obj").write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (bad / "frame_0040.jpg").unlink()
    (bad / "frame_0050.obj").write_bytes(b"")
    # No score is low enough for a candidate: matching is all that is asked here.
    options = replace(built.options, matching=replace(built.options.matching, threshold=0.0))
    build(bad, tmp_path / "work", options, 2, quiet())
    work = open_work(tmp_path / "work")
    faults = {(fault.number, fault.file) for fault in work.capture.faults}
    assert {number for number, _ in faults} == {2, 40, 50}
    scores = work.matching.dissimilarity.scores
    windows = {work.capture.frames[i].number for i in range(len(work.capture)) if np.isfinite(scores[i]).any()}
    k = built.options.matching.k
    assert windows == {n for n in range(100) if all(abs(n - b) > k for b in (-1, 2, 40, 50, 100))}


def test_a_capture_without_a_candidate_keeps_its_matching(built, tmp_path):
    short = tmp_path / "capture"
    short.mkdir()
    for path in built.capture.glob("frame_00[0-2]*"):
        shutil.copy(path, short)
    build(short, tmp_path / "work", built.options, 2, quiet())
    work = open_work(tmp_path / "work")
    assert work.outcomes == [] and not work.graph.cyclic
    assert work.matching.dissimilarity.scores.shape == (30, 30)
    json.dumps(work.graph_json, allow_nan=False)


def test_a_work_folder_in_use_or_of_others_is_refused(built, tmp_path):
    work = tmp_path / "work"
    shutil.copytree(built.work, work)
    with FolderLock(work), pytest.raises(UserError, match="another umg"):
        build(built.capture, work, built.options, 1, quiet())
    with pytest.raises(UserError, match="lies inside the capture"):
        build(built.capture, built.capture / "work", built.options, 1, quiet())
    assert not (built.capture / "work").exists()
    with pytest.raises(UserError, match="there is no such folder"):
        build(tmp_path / "nowhere", tmp_path / "other", built.options, 1, quiet())
    assert not (tmp_path / "other").exists()
