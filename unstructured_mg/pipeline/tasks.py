"""What workers do: one item of a stage each, written aside; the process that holds the work folder's lock commits it.

Every function here can be pickled and sent to another process. What goes wrong with one pair refuses that pair; only
what the user must mend (UserError) ends the build.
"""

import json
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import Refusal, UserError
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.pipeline.store import user_errors
from unstructured_mg.playback.contact_sheet import render_transition_pictures
from unstructured_mg.synthesis.files import read_transition, write_transition
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.synthesize import synthesize
from unstructured_mg.tracking.cage import build_cage, read_cage, write_cage
from unstructured_mg.tracking.files import read_pair, write_pair
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.template import select_template
from unstructured_mg.tracking.track import track_pair

REFUSED = "refused.json"
TEMPLATE = "template.json"


@dataclass(frozen=True)
class TaskResult:
    """What came of an item.

    ``folders`` were made in scratch, in a fixed order; with a ``refusal`` they hold it as ``refused.json``.
    ``traceback`` is there where the refusal is a defect of ours and no verdict: it is not stored then, and the next run
    tries again.
    """

    folders: tuple[Path, ...]
    refusal: Refusal | None
    seconds: float
    traceback: str | None = None


def prepare(capture: Capture, candidate: Candidate, options: TrackingOptions, scratch: Path) -> TaskResult:
    """Choose a candidate's template frame and build its tet cage."""

    def work(folders: list[Path]) -> None:
        template = select_template(capture, candidate, options)
        write_cage(build_cage(capture.read(template), options), folders[0])
        (folders[0] / TEMPLATE).write_text(json.dumps({"template": capture.frame_id(template)}) + "\n")

    return _attempt("tracking", scratch, 1, work)


def track(capture: Capture, candidate: Candidate, cage: Path, options: TrackingOptions, scratch: Path) -> TaskResult:
    """Fit the template that ``prepare`` chose through both windows of a candidate."""

    def work(folders: list[Path]) -> Refusal | None:
        template = capture.index_of(json.loads((cage / TEMPLATE).read_text())["template"])
        found = track_pair(capture, candidate, template, read_cage(cage), options)
        if isinstance(found, Refusal):
            return found
        write_pair(found, capture, folders[0])
        return None

    return _attempt("tracking", scratch, 1, work)


def synthesise(capture: Capture, pair: Path, options: SynthesisOptions, scratch: Path) -> TaskResult:
    """Both transitions of a tracked pair: source to target, then target to source."""

    def work(folders: list[Path]) -> Refusal | None:
        found = synthesize(capture, read_pair(pair), options)
        if isinstance(found, Refusal):
            return found
        for transition, folder in zip(found, folders, strict=True):
            write_transition(transition, folder)
        return None

    return _attempt("synthesis", scratch, 2, work)


def picture(capture: Capture, transition: Path, scratch: Path) -> Path:
    """A transition's pictures for the report, in a folder in scratch."""
    pictures = render_transition_pictures(capture, read_transition(transition))
    with user_errors(scratch):
        folder = Path(tempfile.mkdtemp(dir=scratch))
        for name, content in pictures.files().items():
            (folder / name).write_bytes(content)
    return folder


def read_refusal(folder: Path) -> Refusal | None:
    """The refusal that an artefact holds, or None where it holds a result."""
    path = folder / REFUSED
    return Refusal(**json.loads(path.read_text())) if path.exists() else None


def _attempt(stage: str, scratch: Path, count: int, work: Callable[[list[Path]], Refusal | None]) -> TaskResult:
    started = time.perf_counter()
    with user_errors(scratch):
        folders = [Path(tempfile.mkdtemp(dir=scratch)) for _ in range(count)]
        try:
            refusal = work(folders)
        except (OSError, UserError):
            raise
        except Exception as error:
            # A defect of ours in one pair must not end a night's work.
            refusal = Refusal(stage, f"failed: {type(error).__name__}: {error}")
            return TaskResult(tuple(folders), refusal, time.perf_counter() - started, traceback.format_exc())
        if refusal is not None:
            for folder in folders:
                (folder / REFUSED).write_text(json.dumps(asdict(refusal), indent=1) + "\n")
    return TaskResult(tuple(folders), refusal, time.perf_counter() - started)
