import io
import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from rich.console import Console
from small_build import quiet
from toy_capture import toy_capture

from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.pipeline.build import build
from unstructured_mg.pipeline.summary import _kind, _short_runs, _why_nothing_loops, print_summary, summarise
from unstructured_mg.pipeline.work import open_work


def test_a_summary_counts_what_is_in_the_files(built):
    summary = summarise(open_work(built.work))
    graph = json.loads((built.work / "graph.json").read_text())
    assert (summary.frames, summary.faults, summary.covered) == (100, 0, len(graph["frames"]))
    outcomes = json.loads((built.work / "outcomes.json").read_text())
    assert summary.candidates == len(outcomes)
    assert summary.kept == sum(row["status"] == "kept" for row in outcomes) == 1
    assert sum(count for _, count in summary.refused) == summary.candidates - summary.kept
    assert summary.transitions == len(graph["transitions"]) == 2
    assert summary.played == sum(each["in_graph"] for each in graph["transitions"])
    timings = json.loads((built.work / "timings.json").read_text())
    # Workers run ahead: what they made for nothing is gone, and its time with it.
    seconds = [*timings["stages"].values()]
    seconds += [spent for name, spent in timings["items"].items() if (built.work / name).exists()]
    np.testing.assert_allclose(sum(minutes for _, minutes in summary.minutes), sum(seconds) / 60)


def test_refusals_of_one_kind_are_counted_together():
    reasons = [f"the surface jumps at its start by {mm} mm, {times} times the capture's own change"
               for mm, times in ((7.1, 1.6), (12.0, 3.25))]  # fmt: skip
    assert _kind(reasons[0]) == _kind(reasons[1]) == "the surface jumps at its start by mm"
    assert _kind("planted feet slide by 9.1 cm") != _kind(reasons[0])


def test_the_tables_are_printed(built):
    work, out = open_work(built.work), io.StringIO()
    tried, covered = len(work.outcomes), len(work.graph.frames)
    print_summary(work, Console(file=out, width=200))
    row = next(line for line in out.getvalue().splitlines() if "100" in line)
    cells = [cell.strip() for cell in row.strip("│ ").split("│")]
    assert cells == ["100", *map(str, (covered, tried, tried - 1)), "1", "2", "1"]


def text_of(work):
    """The summary as it stands in a log of 80 columns."""
    console = Console(file=io.StringIO(), width=80)
    print_summary(open_work(work), console)
    return console.file.getvalue()


def test_bad_frames_are_named_in_full_and_a_window_too_long_is_said_so(built, tmp_path):
    folder = tmp_path / "a capture whose path is far wider than any column of the table"
    shutil.copytree(built.capture, folder)
    (folder / "frame_0050.obj").write_text("v 0 0 0 [/bold]\n")
    options = replace(built.options, matching=replace(built.options.matching, k=40))
    build(folder, tmp_path / "work", options, 2, quiet())
    shown = text_of(tmp_path / "work")
    assert "frame_0050.obj" in shown
    assert "no two whole windows of 81 frames" in " ".join(shown.split())


def test_transitions_that_close_no_loop_are_not_denied(built, tmp_path):
    """A gap between the windows of the only pair: both transitions are there, and neither leads to the other."""
    kept = next(row for row in open_work(built.work).outcomes if row["status"] == "kept")
    between = (int(kept["source"]) + int(kept["target"])) // 2
    folder = tmp_path / "capture"
    shutil.copytree(built.capture, folder)
    (folder / f"frame_{between:04d}.obj").unlink()
    shutil.copytree(built.work, tmp_path / "work")
    build(folder, tmp_path / "work", built.options, 2, quiet())
    assert not open_work(tmp_path / "work").graph.cyclic
    assert "Nothing loops: gaps" in " ".join(text_of(tmp_path / "work").split())


def finished(missing, outcomes=(), links=(), capture=None):
    """What the sentences about loops look at; frames are numbered from 1."""
    return SimpleNamespace(
        capture=capture or toy_capture(200),
        matching=SimpleNamespace(missing=missing, threshold=0.07, dissimilarity=SimpleNamespace(unit="m")),
        matching_options=MatchingOptions(k=10),
        outcomes=outcomes,
        graph=SimpleNamespace(links=links),
    )


def test_without_a_way_back_the_three_best_are_named_with_what_became_of_them():
    pairs = [Candidate(19, 99, 0.05, 0, 10), Candidate(29, 129, 0.06, 0, 10), Candidate(39, 139, 0.09, 0, 12)]
    outcomes = [{"source": "20", "target": "100", "refusal": {"stage": "synthesis", "reason": "feet slide"}}]
    text = _why_nothing_loops(finished((*pairs, Candidate(60, 160, 0.2, 0, 10)), outcomes))
    assert text.splitlines() == [
        "Nothing loops: no transition was made.",
        "Each of these would close a loop; none comes nearer:",
        "  from 90 back to 30: 50 mm apart; refused: feet slide",
        "  from 120 back to 40: 60 mm apart; was not tried",
        "  from 128 back to 52: 90 mm apart; candidates differ by 70 mm at most",
    ]
    assert _why_nothing_loops(finished((), links=(1,))).startswith("Nothing loops: gaps")


def test_runs_shorter_than_a_window_are_for_playback_only():
    clips = toy_capture(30, 8, 21, 20, clips=True)
    assert _short_runs(finished((), capture=clips)) == (
        "Only for playback, as no window of 21 frames fits: frames b:1 to b:8, d:1 to d:20."
    )
    assert _short_runs(finished(())) == ""
