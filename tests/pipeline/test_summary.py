import io
import json

import numpy as np
from rich.console import Console

from unstructured_mg.pipeline.summary import _kind, print_summary, summarise
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
