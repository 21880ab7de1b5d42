"""The two tables at a build's end, in the rows of P Tables 1 and 2."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from unstructured_mg.pipeline.work import Work
from unstructured_mg.playback.svg import apart


@dataclass(frozen=True)
class Summary:
    """What a build came to.

    ``frames`` captured and good, ``covered`` of them in the graph; ``candidates`` tried, of which ``refused`` (reasons
    and how often) and ``kept``; ``transitions`` made, ``played`` of them in the graph; ``minutes`` a stage.
    """

    frames: int
    faults: int
    covered: int
    candidates: int
    kept: int
    refused: tuple[tuple[str, int], ...]
    transitions: int
    played: int
    minutes: tuple[tuple[str, float], ...]


def summarise(work: Work) -> Summary:
    """Count what a finished work folder holds."""
    graph, outcomes = work.graph, work.outcomes
    refusals = [row["refusal"] for row in outcomes if row["refusal"] is not None]
    reasons = Counter(f"{refusal['stage']}: {_kind(refusal['reason'])}" for refusal in refusals)
    return Summary(
        frames=len(work.capture),
        faults=len(work.capture.faults),
        covered=len(graph.frames) if graph.cyclic else 0,
        candidates=len(outcomes),
        kept=len(outcomes) - len(refusals),
        refused=tuple(sorted(reasons.items())),
        transitions=len(graph.links),
        played=len(graph.links_used()),
        minutes=_minutes(work),
    )


def print_summary(work: Work, console: Console) -> None:
    """Print the tables of a finished work folder, and its capture's faults and warnings."""
    summary = summarise(work)
    for warning in work.capture.warnings:
        console.print(f"[yellow]{escape(warning)}[/yellow]")
    if work.capture.faults:
        faults = Table(title="Frames that could not be used", title_justify="left")
        for heading in ("file", "fault", "remedy"):
            faults.add_column(heading, overflow="fold")
        for fault in work.capture.faults:
            file = Path(fault.file)
            if file.is_relative_to(work.capture.folder):
                file = file.relative_to(work.capture.folder)
            faults.add_row(*(escape(text) for text in (file.as_posix(), fault.fault, fault.remedy)))
        console.print(faults)
    error, unit = work.matching.dissimilarity.rank_error, work.matching.dissimilarity.unit
    if error is not None:
        console.print(
            f"Scores are approximate: off by {apart(error, unit)} at most on frames that were compared exactly."
        )
    if short := _short_runs(work):
        console.print(short, markup=False)
    counts = Table(title="Frames and transitions", title_justify="left")
    for heading in ("frames", "in the graph", "candidates", "refused", "kept", "transitions", "in the graph"):
        counts.add_column(heading, justify="right")
    refused = summary.candidates - summary.kept
    row = (summary.frames, summary.covered, summary.candidates, refused)
    counts.add_row(*map(str, (*row, summary.kept, summary.transitions, summary.played)))
    console.print(counts)
    for reason, count in summary.refused:
        console.print(f"  refused {count} x {reason}")
    minutes = Table(title="Minutes", title_justify="left")
    minutes.add_column("stage")
    minutes.add_column("minutes", justify="right")
    for stage, value in summary.minutes:
        minutes.add_row(stage, f"{value:.2f}")
    minutes.add_section()
    minutes.add_row("total", f"{sum(value for _, value in summary.minutes):.2f}")
    console.print(minutes)
    if not work.graph.cyclic:
        console.print(_why_nothing_loops(work), markup=False)


def _short_runs(work: Work) -> str:
    """Names the runs of frames in which no window fits; empty where there are none."""
    length, name = 2 * work.matching_options.k + 1, work.capture.frame_id
    short = [f"{name(run[0])} to {name(run[-1])}" for run in work.capture.runs() if len(run) < length]
    if not short:
        return ""
    return f"Only for playback, as no window of {length} frames fits: frames {', '.join(short)}."


def _why_nothing_loops(work: Work) -> str:
    """That there is no way back, and the three best transitions that would be one, with what became of them."""
    missing, options = work.matching.missing[:3], work.matching_options
    if work.graph.links:
        why = "gaps, or the ends of clips, cut the way back from every transition; mend missing frames."
    elif missing:
        why = "no transition was made."
    else:
        frames, gap = 2 * options.k + 1, options.minimum_gap_seconds
        why = f"no two whole windows of {frames} frames of a clip lie {gap:g} seconds apart; give a smaller --window."
    unit, name = work.matching.dissimilarity.unit, work.capture.frame_id
    became = {(row["source"], row["target"]): row for row in work.outcomes}
    lines = [f"Nothing loops: {why}"] + ["Each of these would close a loop; none comes nearer:"] * bool(missing)
    for pair in missing:
        row = became.get((name(pair.source), name(pair.target)))
        if pair.score > work.matching.threshold:
            fate = f"candidates differ by {apart(work.matching.threshold, unit)} at most"
        elif row is None:
            fate = "was not tried"
        else:
            fate = "kept" if row["refusal"] is None else f"refused: {row['refusal']['reason']}"
        where = f"  from {name(pair.target - pair.k)} back to {name(pair.source + pair.k)}"
        lines.append(f"{where}: {apart(pair.score, unit)} apart; {fate}")
    return "\n".join(lines)


def _minutes(work: Work) -> tuple[tuple[str, float], ...]:
    """Wall time of stages that use all workers together; of the pairs, the workers' own time added up."""
    timings = work.timings
    wall = [
        (stage, timings.stages.get(stage, 0.0)) for stage in ("reading", "matching", "candidates", "places", "graph")
    ]
    pairs = [
        ("cages", "cages (worker time)"),
        ("pairs", "tracking (worker time)"),
        ("transitions", "synthesis (worker time)"),
    ]
    worker = [(title, timings.total(group, work.store.names(group))) for group, title in pairs]
    return tuple((stage, seconds / 60) for stage, seconds in [*wall[:2], *worker, *wall[2:]])


def _kind(reason: str) -> str:
    """A reason without its numbers, so that like refusals are counted together."""
    words = reason.split(", ", 1)[0].split(";")[0].split(" (")[0]
    return " ".join(word for word in words.split() if not any(letter.isdigit() for letter in word)).rstrip(".:")
