"""``umg clean``: what neither walks nor reports need, out of a work folder."""

import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.lock import FolderLock
from unstructured_mg.pipeline.store import Store, user_errors
from unstructured_mg.pipeline.tasks import read_refusal

# Artefact groups; anything in these folders that no manifest knows is left over.
GROUPS = ("cages", "pairs", "transitions", "pictures")
REPORT = "report.html"


@dataclass(frozen=True)
class Cleaned:
    """What goes: a ``kind`` of things, how many, their ``bytes``, and what brings them back (empty: nothing)."""

    kind: str
    count: int
    bytes: int
    again: str


def clean(folder: Path, dry_run: bool) -> tuple[Cleaned, ...]:
    """Remove what can be made again, and say what it was.

    These are the tracked surfaces of pairs whose transitions are there, the report and its pictures, and leftovers.
    Cages stay, for their maker may not repeat them, and so do refusals: the next build of the same options has nothing
    to do. Raises UserError where ``folder`` is no work folder or is being written.
    """
    store = Store(folder)
    if not (store.root / "work.json").exists():
        raise UserError(f"{folder}: is not a work folder; there is nothing of umg's to clean.")
    with FolderLock(store.root):
        tracked = [name for name in store.names("pairs") if _finished(store, name)]
        pictures = store.names("pictures")
        report = [path for path in (store.path(REPORT),) if path.exists()]
        known = {store.path(name) for group in GROUPS for name in store.names(group)}
        stray = [path for group in GROUPS for path in store.path(group).glob("*") if path not in known]
        leftovers = sorted(stray) + [path for path in (store.scratch,) if path.exists()]
        shown = [*map(store.path, pictures), *report]
        cleaned = (
            Cleaned("tracked pairs", len(tracked), _sizes(map(store.path, tracked)), "umg build with other options"),
            Cleaned("pictures and report", len(shown), _sizes(shown), "umg report"),
            Cleaned("leftovers", len(leftovers), _sizes(leftovers), ""),
        )
        if not dry_run:
            with user_errors(store.root):
                for name in tracked + pictures:
                    store.remove(name)
                for path in report + leftovers:
                    shutil.rmtree(path) if path.is_dir() else path.unlink()
    return cleaned


def print_cleaning(cleaned: tuple[Cleaned, ...], dry_run: bool, console: Console) -> None:
    table = Table()
    table.add_column("would go" if dry_run else "gone")
    table.add_column("number", justify="right")
    table.add_column("MB", justify="right")
    table.add_column("made again by")
    for each in cleaned:
        table.add_row(each.kind, str(each.count), f"{each.bytes / 1e6:.1f}", each.again)
    console.print(table)


def _finished(store: Store, pair: str) -> bool:
    """Whether both transitions of a tracked pair are there and whole; a refused pair is small and stays."""
    name = pair.removeprefix("pairs/")
    # The names of clips may hold hyphens as well: any of them may be the one between the frames.
    ways_back = [f"transitions/{name[i + 1 :]}-{name[:i]}" for i, letter in enumerate(name) if letter == "-"]
    return (
        read_refusal(store.path(pair)) is None
        and store.verify(f"transitions/{name}") is not None
        and any(store.verify(way) is not None for way in ways_back)
    )


def _sizes(paths: Iterable[Path]) -> int:
    files = (file for path in paths for file in ([path] if path.is_file() else path.rglob("*")))
    return sum(file.stat().st_size for file in files if file.is_file())
