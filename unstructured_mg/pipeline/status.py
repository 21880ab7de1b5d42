"""``umg status``: what a work folder holds, without touching it."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.lock import lock_holder
from unstructured_mg.pipeline.store import Store
from unstructured_mg.pipeline.tasks import read_refusal
from unstructured_mg.pipeline.timings import Timings

# Artefacts that are one a work folder, and those that are one a pair or transition, in the order of the build.
SINGLE = ("capture.json", "matching", "candidates.json", "outcomes.json", "places.json", "graph.json")
GROUPS = ("cages", "pairs", "transitions", "pictures")
ORDER = (
    "capture.json",
    "matching",
    "candidates.json",
    "cages",
    "pairs",
    "transitions",
    "outcomes.json",
    "places.json",
    "graph.json",
    "pictures",
)


@dataclass(frozen=True)
class StageStatus:
    """Of an artefact or a group of them: how many are ``whole``, how many of these ``refused``, names of the
    ``damaged``.
    """

    name: str
    whole: int
    refused: int
    damaged: tuple[str, ...]


@dataclass(frozen=True)
class WorkStatus:
    """``finished``: the last build ended well; ``holder``: who is writing there, or None; ``frames`` and ``faults``
    are None where the capture has not been read; ``leftovers``: files of a build that did not end well.
    """

    folder: Path
    finished: bool
    holder: str | None
    source: str | None
    frames: int | None
    faults: int | None
    stages: tuple[StageStatus, ...]
    worker_minutes: float
    leftovers: int


def work_status(folder: Path) -> WorkStatus:
    """Look at every artefact and its checksums. Raises UserError where ``folder`` is no work folder."""
    store = Store(folder)
    if not (store.root / "work.json").exists():
        raise UserError(f"{folder}: is not a work folder; make one with umg build CAPTURE -o {folder}.")
    stages = []
    for name in ORDER:
        names = store.names(name) if name in GROUPS else [name] if store.manifest(name) is not None else []
        whole = [each for each in names if store.verify(each) is not None]
        refused = [each for each in whole if name in GROUPS and read_refusal(store.path(each)) is not None]
        damaged = tuple(each for each in names if each not in whole)
        if names:
            stages.append(StageStatus(name, len(whole), len(refused), damaged))
    made = {stage.name for stage in stages if not stage.damaged}
    capture = _capture(store) if "capture.json" in made else {}
    scratch = list(store.scratch.rglob("*")) if store.scratch.exists() else []
    return WorkStatus(
        folder=store.root,
        finished="graph.json" in made and "capture.json" in made,
        holder=lock_holder(store.root),
        source=capture.get("folder"),
        frames=len(capture["frames"]) if capture else None,
        faults=len(capture["faults"]) if capture else None,
        stages=tuple(stages),
        worker_minutes=sum(Timings(store.path("timings.json")).items.values()) / 60,
        leftovers=sum(path.is_file() for path in scratch),
    )


def print_status(status: WorkStatus, console: Console) -> None:
    """Print it as a table and sentences."""
    if status.source is not None:
        console.print(f"{escape(status.source)}: {status.frames} frames, {status.faults} unusable", highlight=False)
    table = Table()
    table.add_column("artefacts")
    for heading in ("whole", "of these refused", "damaged"):
        table.add_column(heading, justify="right")
    for stage in status.stages:
        refused = str(stage.refused) if stage.name in GROUPS else ""
        table.add_row(stage.name, str(stage.whole), refused, str(len(stage.damaged)))
    console.print(table)
    for stage in status.stages:
        for name in stage.damaged:
            console.print(f"{name} is damaged; the next umg build makes it again.", markup=False, highlight=False)
    console.print(f"Workers spent {status.worker_minutes:.1f} minutes on pairs.", highlight=False)
    if status.holder is not None:
        console.print(f"It is being written now ({status.holder}).", markup=False, highlight=False)
    elif not status.finished:
        console.print("The build has not finished; run umg build with the same arguments again.")
    if status.leftovers and status.holder is None:
        console.print(f"{status.leftovers} files were left by a kill; the next umg build sweeps them away.")


def _capture(store: Store) -> dict[str, Any]:
    return json.loads(store.path("capture.json").read_text())
