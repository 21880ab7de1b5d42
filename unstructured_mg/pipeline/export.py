"""Walks and paths out of a work folder, as files."""

from pathlib import Path

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.keys import file_hash
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.work import Work
from unstructured_mg.playback.export_obj import export_obj
from unstructured_mg.playback.stream import posed_frames
from unstructured_mg.playback.walk import Walk


def export_walk(work: Work, walk: Walk, out: Path, force: bool, workers: int, progress: StageProgress) -> None:
    """Write a walk as OBJ + MTL + image frames and walk.json into ``out``."""
    if Path(out).resolve().is_relative_to(work.capture.folder.resolve()):
        raise UserError(f"{out}: lies inside the capture, where it would count as a clip; give a folder elsewhere.")
    frames = posed_frames(walk.frames, work.capture, work.load_transition)
    inputs = {"graph.json": file_hash(work.store.path("graph.json"))}
    with Pool(workers) as pool, progress.stage("exporting frames") as advance:
        export_obj(
            frames,
            work.capture,
            walk,
            Path(out),
            force=force,
            inputs=inputs,
            executor=pool.executor,
            progress=advance,
        )
