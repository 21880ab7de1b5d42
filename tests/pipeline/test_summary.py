import io
import json

from rich.console import Console

from unstructured_mg.pipeline.summary import _kind, print_summary, summarise
from unstructured_mg.pipeline.work import open_work


def test_a_summary_counts_what_is_in_the_files(built):
    summary = summarise(open_work(built.work))
    graph = json.loads((built.work / "graph.json").read_text())
    assert (summary.frames, summary.faults, summary.covered) == (100, 0, len(graph["frames"]))
    assert (summary.candidates, summary.kept, summary.refused) == (1, 1, ())
    assert summary.transitions == len(graph["transitions"]) == 2
    assert summary.played == sum(each["in_graph"] for each in graph["transitions"])
    timings = json.loads((built.work / "timings.json").read_text())
    minutes = dict(summary.minutes)
    assert minutes["matching"] == timings["stages"]["matching"] / 60
    assert abs(sum(minutes.values()) - sum([*timings["stages"].values(), *timings["items"].values()]) / 60) < 1e-12


def test_refusals_of_one_kind_are_counted_together():
    reasons = [f"the surface jumps at its start by {mm} mm, {times} times the capture's own change"
               for mm, times in ((7.1, 1.6), (12.0, 3.25))]  # fmt: skip
    assert _kind(reasons[0]) == _kind(reasons[1]) == "the surface jumps at its start by mm"
    assert _kind("planted feet slide by 9.1 cm") != _kind(reasons[0])


def test_the_tables_are_printed(built):
    work, out = open_work(built.work), io.StringIO()
    print_summary(work, Console(file=out, width=200))
    row = next(line for line in out.getvalue().splitlines() if "100" in line)
    cells = [cell.strip() for cell in row.strip("│ ").split("│")]
    assert cells == ["100", str(summarise(work).covered), "1", "0", "1", "2", "1"]
