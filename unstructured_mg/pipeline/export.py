"""Walks and paths out of a work folder, and plain captures, as files."""

from pathlib import Path

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.keys import file_hash
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.work import Work
from unstructured_mg.playback.export import export_walk, find_format
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.stream import LoadTransition
from unstructured_mg.playback.walk import Walk, capture_walk


def export_work(
    work: Work, walk: Walk, out: Path, options: ExportOptions, force: bool, workers: int, progress: StageProgress
) -> int:
    """Write a walk of a build and walk.json into ``out``; how many frames it shows."""
    inputs = {"graph.json": file_hash(work.store.path("graph.json"))}
    return _export(walk, work.capture, work.load_transition, out, options, force, inputs, workers, progress)


def export_capture(
    capture: Capture, out: Path, options: ExportOptions, force: bool, workers: int, progress: StageProgress
) -> int:
    """Write a capture's frames as they are and walk.json into ``out``; how many frames it shows."""
    return _export(capture_walk(capture), capture, None, out, options, force, {}, workers, progress)


def _export(
    walk: Walk,
    capture: Capture,
    load_transition: LoadTransition | None,
    out: Path,
    options: ExportOptions,
    force: bool,
    inputs: dict[str, str],
    workers: int,
    progress: StageProgress,
) -> int:
    find_format(options)  # what is asked for in vain is said before workers start
    if Path(out).resolve().is_relative_to(capture.folder.resolve()):
        raise UserError(f"{out}: lies inside the capture, where it would count as a clip; give a folder elsewhere.")
    with Pool(workers) as pool, progress.stage("exporting frames") as advance:
        return export_walk(
            walk,
            capture,
            load_transition,
            Path(out),
            options,
            force=force,
            inputs=inputs,
            executor=pool.executor,
            progress=advance,
        )
