"""A build of a small procedural capture, without output."""

import io
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.pipeline.options import BuildOptions
from unstructured_mg.pipeline.progress import StageProgress

# As strict a threshold as leaves a pair or two: what is tried costs time.
OPTIONS = BuildOptions(matching=MatchingOptions(k=3, resolution=32, threshold=0.025), max_pairs=1)


@dataclass(frozen=True)
class Built:
    capture: Path
    work: Path
    options: BuildOptions


def quiet() -> StageProgress:
    return StageProgress(Console(file=io.StringIO()))
