"""A build from end to end, as long as P's longest: minutes a stage beside P Table 2, memory, and what a resume costs.

The capture is procedural: 10k faces and 1 Mpixel a frame, remeshed in every frame, seed 0. Making it is not timed; it
is kept in --captures and made once. One pair is kept for every 43 frames: 53 at 2283, the paper's candidates (it
tracked 38). Each size runs in a process of its own, so that memory peaks are its own.

    python benchmarks/pipeline.py [--frames 2283 ...] [--workers 2] [--captures FOLDER] [--quick] [--json FILE]
"""

import argparse
import io
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from unstructured_mg.pipeline.pool import Pool, single_thread

single_thread()  # before NumPy comes in with the rooms

from rich.console import Console  # noqa: E402

from unstructured_mg.capture.procedural import write_procedural  # noqa: E402
from unstructured_mg.capture.progress import Progress  # noqa: E402
from unstructured_mg.pipeline.build import build  # noqa: E402
from unstructured_mg.pipeline.options import BuildOptions  # noqa: E402
from unstructured_mg.pipeline.progress import StageProgress  # noqa: E402
from unstructured_mg.pipeline.work import open_work  # noqa: E402

FACES, TEXTURE, SEED, FRAMES_A_PAIR = 10_000, 1024, 0, 43
# P Table 2, Slick Magic: 2283 frames, 4 cores, minutes.
PAPER = {
    "reading": None,
    "descriptors": 1.0,
    "comparing windows": 9.0,
    "cages": 5.0,
    "tracking": 168.0 + 36 + 38 + 37,
    "synthesis": 172.0,
    "probabilities": 1.0,
    "total": 478.0,
}
MIB = 1024  # kilobytes, as the system counts peaks


class PhaseClock(StageProgress):
    """Also notes how long the stages took, matching in its two halves."""

    def __init__(self) -> None:
        super().__init__(Console(file=io.StringIO()))
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, title: str) -> Iterator[Progress]:
        began = time.perf_counter()
        described: list[float] = []

        def advance(done: int, total: int) -> None:
            if not described and total and 3 * done >= 2 * total:
                described.append(time.perf_counter())

        yield advance
        ended = time.perf_counter()
        self.seconds[title] = ended - began
        if title == "matching windows" and described:
            self.seconds["descriptors"], self.seconds["comparing windows"] = described[0] - began, ended - described[0]


def make_capture(folder: Path, frames: int, workers: int) -> Path:
    """The capture of that many frames, made where it is not there."""
    capture = folder / f"procedural_{frames}_{FACES}_{TEXTURE}_{SEED}"
    if not capture.exists():
        partial = capture.with_name(capture.name + ".partial")
        shutil.rmtree(partial, ignore_errors=True)
        with Pool(workers) as pool:
            write_procedural(
                partial, frames=frames, faces=FACES, texture_size=TEXTURE, seed=SEED, executor=pool.executor
            )
        partial.rename(capture)
    return capture


def cpu_seconds() -> float:
    """User and system time of this process and of all its ended workers."""
    return sum(use.ru_utime + use.ru_stime for use in map(resource.getrusage, USERS))


USERS = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)


def measure(capture: Path, frames: int, workers: int) -> dict[str, float]:
    """Build, then run the same command again; seconds, megabytes and counts."""
    options = BuildOptions(max_pairs=max(1, round(frames / FRAMES_A_PAIR)))
    with tempfile.TemporaryDirectory(dir=capture.parent) as folder:
        work = Path(folder) / "work"
        clock = PhaseClock()
        began, used = time.perf_counter(), cpu_seconds()
        build(capture, work, options, workers, clock)
        row: dict[str, float] = {"total": time.perf_counter() - began, "cpu": cpu_seconds() - used}
        own, workers_peak = (resource.getrusage(user).ru_maxrss / MIB for user in USERS)
        began, used = time.perf_counter(), cpu_seconds()
        build(capture, work, options, workers, PhaseClock())
        row |= {"resume": time.perf_counter() - began, "resume cpu": cpu_seconds() - used}
        opened = open_work(work)
        timings = opened.timings
        row |= {
            "frames": frames,
            "candidates": len(opened.matching.candidates),
            "tried": len(opened.outcomes),
            "kept": sum(outcome["refusal"] is None for outcome in opened.outcomes),
            "covered": len(opened.graph.frames) if opened.graph.cyclic else 0,
            "reading": clock.seconds["reading frames"],
            "descriptors": clock.seconds.get("descriptors", 0.0),
            "comparing windows": clock.seconds.get("comparing windows", 0.0),
            "cages": timings.total("cages") / workers,
            "tracking": timings.total("pairs") / workers,
            "synthesis": timings.total("transitions") / workers,
            "probabilities": clock.seconds["graph and probabilities"],
            "worker MiB": workers_peak,
            "main MiB": own,
            "work folder MiB": sum(path.stat().st_size for path in work.rglob("*") if path.is_file()) / 2**20,
        }
    return row


def measure_apart(capture: Path, frames: int, workers: int) -> dict[str, float]:
    """``measure`` in a process of its own."""
    command = [sys.executable, __file__, "--measure", str(capture), "--frames", str(frames), "--workers", str(workers)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout)


def print_rows(rows: list[dict[str, float]], workers: int) -> None:
    heads = [f"{row['frames']:.0f} frames" for row in rows]
    print(f"{'minutes':24}" + "".join(f"{head:>14}" for head in heads) + f"{'P, 4 cores':>14}")
    for name, paper in PAPER.items():
        beside = "" if paper is None else f"{paper:.0f}"
        print(f"{name:24}" + "".join(f"{row[name] / 60:14.2f}" for row in rows) + f"{beside:>14}")
    print(
        f"(cages, tracking, synthesis: the workers' own time over {workers} workers; P's tracking: 168 + 36 + 38 + 37)"
    )
    for name, unit in (
        ("cpu", "s"),
        ("candidates", ""),
        ("tried", ""),
        ("kept", ""),
        ("covered", "frames"),
        ("worker MiB", ""),
        ("main MiB", ""),
        ("work folder MiB", ""),
        ("resume", "s"),
        ("resume cpu", "s"),
    ):
        print(f"{f'{name}, {unit}'.rstrip(', '):24}" + "".join(f"{row[name]:14.1f}" for row in rows))


def figures(rows: list[dict[str, float]]) -> list[dict[str, object]]:
    """What is to be reached at 2283 frames, and of memory at every size."""
    found: list[dict[str, object]] = []
    for row in rows:
        size = f"{row['frames']:.0f} frames"
        long = row["frames"] >= 2283
        for name, value, unit, reach in (
            ("end to end", row["total"] / 60, "min", 15.0 if long else None),
            ("processor time", row["cpu"] / 60, "min", None),
            ("peak memory of a worker", row["worker MiB"] / 1024, "GiB", 2.0),
            ("resume with nothing left to do", row["resume"], "s", 5.0 if long else None),
        ):
            holds = None if reach is None else value <= reach
            found.append({"name": f"{name}, {size}", "value": value, "unit": unit, "reach": reach, "holds": holds})
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, nargs="+", default=[2283], help="sizes, one build each")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--captures", type=Path, default=Path(tempfile.gettempdir()) / "umg_benchmark_captures")
    parser.add_argument("--quick", action="store_true", help="100 frames only")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.measure:
        print(json.dumps(measure(arguments.measure, arguments.frames[0], arguments.workers)))
        return
    arguments.captures.mkdir(parents=True, exist_ok=True)
    rows = []
    for frames in [100] if arguments.quick else arguments.frames:
        capture = make_capture(arguments.captures, frames, arguments.workers)
        rows.append(measure_apart(capture, frames, arguments.workers))
    print_rows(rows, arguments.workers)
    for figure in figures(rows):
        value = f"{figure['value']:.3g} {figure['unit']}"
        print(f"{figure['name']}: {value} (reach {figure['reach']}, holds: {figure['holds']})")
    if arguments.json:
        arguments.json.write_text(json.dumps(figures(rows), indent=1) + "\n")


if __name__ == "__main__":
    main()
