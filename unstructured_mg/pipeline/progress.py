"""Progress on the terminal: a bar a stage, with the time left."""

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from unstructured_mg.capture.progress import Progress as Advance


class StageProgress:
    """Bars for the stages of a run; plain lines where the output is no terminal. ``explain``: say why work is done."""

    def __init__(self, console: Console, explain: bool = False):
        self._console = console
        self._explain = explain

    @contextmanager
    def stage(self, title: str) -> Iterator[Advance]:
        """A bar for one stage; call what it yields with (done, total)."""
        if not self._console.is_terminal:
            self._console.print(f"{title} ...")
            yield lambda done, total: None
            return
        columns = [
            TextColumn("{task.description:<32}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
        ]
        with Progress(*columns, console=self._console) as bars:
            task = bars.add_task(title, total=None)
            yield lambda done, total: bars.update(task, completed=done, total=total)

    def note(self, text: str) -> None:
        """A line that stays."""
        self._console.print(text)

    def why(self, name: str, reason: str) -> None:
        """A line that stays, where reasons are asked for."""
        if self._explain:
            self._console.print(f"{name} {reason}", markup=False, highlight=False, soft_wrap=True)
