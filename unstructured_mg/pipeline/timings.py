"""How long a build took, over all its runs. Not an artefact: times differ from run to run, results do not."""

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from unstructured_mg.pipeline.store import write_whole


class Timings:
    """``timings.json``: seconds of wall time per stage, and worker seconds per item (an artefact's name)."""

    def __init__(self, path: Path):
        self._path = path
        try:
            content = json.loads(path.read_text())
        except (OSError, ValueError, RecursionError):
            content = {}
        self.stages: dict[str, float] = _numbers(content, "stages")
        self.items: dict[str, float] = _numbers(content, "items")

    @contextmanager
    def wall(self, stage: str) -> Iterator[None]:
        """Time a stage; a stage that runs again replaces its figure."""
        started = time.perf_counter()
        yield
        self.stages[stage] = time.perf_counter() - started

    def total(self, group: str, names: list[str] | None = None) -> float:
        """Worker seconds of all items ``group/...``, or of those in ``names``."""
        wanted = None if names is None else set(names)
        return sum(
            seconds
            for name, seconds in self.items.items()
            if name.startswith(f"{group}/") and (wanted is None or name in wanted)
        )

    def save(self) -> None:
        content = {"stages": self.stages, "items": dict(sorted(self.items.items()))}
        write_whole(self._path, (json.dumps(content, indent=1) + "\n").encode())


def _numbers(content: Any, key: str) -> dict[str, float]:
    """What the file has under ``key``; nothing where it is damaged, for no result hangs on it."""
    found = content.get(key) if isinstance(content, dict) else None
    if not isinstance(found, dict):
        return {}
    return {name: float(value) for name, value in found.items() if isinstance(value, int | float)}
