"""``umg report``: a work folder's pictures and its page."""

import shutil
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg import __version__
from unstructured_mg.errors import Refusal, UserError
from unstructured_mg.graph.uniformity import obstacle_sentence
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.pipeline import tasks
from unstructured_mg.pipeline.lock import FolderLock
from unstructured_mg.pipeline.names import pair_name
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.store import user_errors
from unstructured_mg.pipeline.summary import summarise
from unstructured_mg.pipeline.work import Work, open_work
from unstructured_mg.playback.pair_picture import render_pair_picture
from unstructured_mg.playback.pictures import read_pictures
from unstructured_mg.playback.report import write_report
from unstructured_mg.playback.report_data import PairOutcome, ReportData, TransitionEntry

# Raised when the pictures of the same transition would look otherwise.
PICTURES_VERSION = 1


def make_report(folder: Path, out: Path | None, workers: int, progress: StageProgress) -> Path:
    """Render what is not rendered yet, and write the page to ``out`` (the work folder's report.html where None)."""
    work = open_work(folder)
    written = out or work.store.path("report.html")
    if written.is_dir():
        raise UserError(f"{written}: is a folder; give the name of the file to write with -o.")
    if not written.parent.is_dir():
        raise UserError(f"{written}: there is no folder {written.parent}; make it or give another file with -o.")
    with FolderLock(work.store.root) as lock, Pool(workers) as pool:
        work.store.guard = lock.check
        work.store.clear_scratch()
        try:
            with progress.stage("rendering pictures") as advance:
                _render(work, pool, advance)
        except BaseException:
            pool.kill()  # before scratch is cleared, or workers would go on writing there
            raise
        finally:
            shutil.rmtree(work.store.scratch, ignore_errors=True)
        with user_errors(written):
            write_report(report_data(work), written)
    return written


def _render(work: Work, pool: Pool, advance: Any) -> None:
    store, capture = work.store, work.capture
    futures: list[tuple[str, dict[str, Any], Future[Path]]] = []
    for link in work.graph.links:
        transition = pair_name(capture, link.source, link.target, "transitions")
        name = pair_name(capture, link.source, link.target, "pictures")
        key = (store.manifest(transition) or {}).get("key")
        inputs = {"stage": "pictures", "stage_version": PICTURES_VERSION, "transition": key}
        if store.find(name, inputs) is None:
            task = pool.submit(tasks.picture, capture, store.path(transition), store.scratch)
            futures.append((name, inputs, task))
    for done, (name, inputs, future) in enumerate(futures):
        advance(done, len(futures))
        store.commit(name, inputs, future.result())
    advance(len(futures), len(futures))


def report_data(work: Work) -> ReportData:
    """What the report shows, from a work folder."""
    capture, graph, matching, summary = work.capture, work.graph, work.matching, summarise(work)
    covered, before, after = None, None, None
    if graph.cyclic and graph.visits is not None and graph.visits_even is not None:
        covered = np.zeros(len(capture), bool)
        covered[graph.frames] = True
        before, after = np.zeros(len(capture)), np.zeros(len(capture))
        before[graph.frames], after[graph.frames] = graph.visits_even, graph.visits
    used = graph.links_used()
    cards = {(row["source"], row["target"]): row["quality"] for row in work.graph_json["transitions"]}
    transitions = tuple(
        TransitionEntry(
            link.source,
            link.target,
            link.k,
            link.alignment,
            link.cost,
            cards[capture.frame_id(link.source), capture.frame_id(link.target)],
            index in used,
            link.ends,
        )
        for index, link in enumerate(graph.links)
    )
    gap = max(round(work.matching_options.minimum_gap_seconds * capture.fps), 2 * work.matching_options.k + 1)
    notes = [obstacle_sentence(obstacle, capture) for obstacle in graph.obstacles]
    return ReportData(
        title=f"Motion graph of {capture.folder.name}",
        capture=capture,
        capture_summary=_capture_rows(work),
        scores=matching.dissimilarity.scores,
        unit=matching.dissimilarity.unit,
        threshold=matching.threshold,
        gap=gap,
        candidates=matching.candidates,
        nearest=matching.nearest,
        pairs=tuple(_pair(work, row) for row in work.outcomes),
        transitions=transitions,
        covered=covered,
        visiting_before=before,
        visiting_after=after,
        stage_minutes=summary.minutes,
        pictures=lambda s, t: read_pictures(work.verified(pair_name(capture, s, t, "pictures"))),
        pair_picture=lambda candidate: render_pair_picture(capture, candidate),
        limits=work.synthesis_options,
        notes=tuple(notes),
        version=__version__,
    )


def _capture_rows(work: Work) -> tuple[tuple[str, str], ...]:
    capture = work.capture
    return (
        ("Folder", str(capture.folder)),
        ("Frames", f"{len(capture)} usable, {len(capture.faults)} not"),
        ("Clips", str(len(capture.clips))),
        ("Frames a second", f"{capture.fps:g}"),
        ("Unit", f"{capture.unit:g} m"),
        ("Up axis", capture.up),
        ("Floor", f"{capture.floor:.4g} along the up axis"),
        ("Half window", f"{work.matching_options.k} frames"),
    )


def _pair(work: Work, row: dict[str, Any]) -> PairOutcome:
    source, target = work.capture.index_of(row["source"]), work.capture.index_of(row["target"])
    ways = [tuple(map(work.capture.index_of, way)) for way in row["warp"] or ()]
    warp = (ways[0], ways[1]) if ways else None
    candidate = Candidate(source, target, row["score"], row["yaw"], row["k"], warp)
    if row["refusal"] is None:
        return PairOutcome(candidate, "kept")
    refusal = Refusal(**row["refusal"])
    return PairOutcome(candidate, "refused", refusal.stage, refusal.reason, refusal.measures)
