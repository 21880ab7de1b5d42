"""``umg build``: the rooms in order over a work folder, resumable item by item."""

import json
import shutil
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from contextlib import contextmanager, suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from unstructured_mg.capture.capture import Capture, frame_hash
from unstructured_mg.capture.reader import open_capture
from unstructured_mg.errors import UserError
from unstructured_mg.graph.construction import CONSTRUCTIONS
from unstructured_mg.graph.files import graph_to_json
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.places import Places
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.matching.files import read_candidates, read_matching, write_matching
from unstructured_mg.matching.match import Matching, match
from unstructured_mg.pipeline.choices import CHOICES_FILE, Choices, chosen_candidates, read_choices
from unstructured_mg.pipeline.cluster import ClusterPool
from unstructured_mg.pipeline.lock import FolderLock
from unstructured_mg.pipeline.names import pair_name
from unstructured_mg.pipeline.options import BuildOptions
from unstructured_mg.pipeline.pair_loop import Outcome, PairLoop
from unstructured_mg.pipeline.places import captured_places
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.pools import open_pool
from unstructured_mg.pipeline.preview import preview_capture, preview_inputs
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.store import Store, user_errors
from unstructured_mg.pipeline.timings import Timings
from unstructured_mg.synthesis.files import read_card, read_floor_centres

VERSIONS = {"reading": 1, "matching": 4, "outcomes": 2, "graph": 2, "candidates": 1}


def build(
    folder: Path,
    work: Path,
    options: BuildOptions,
    workers: int,
    progress: StageProgress,
    address: str | None = None,
) -> None:
    """Build, or finish building, a motion graph of the capture in ``folder`` inside the work folder ``work``.

    Tasks run in so many ``workers``, or in those of the Dask scheduler at ``address``, which see both folders under the
    same paths.

    Raises UserError where there is nothing to build or the work folder cannot be used; what was finished until then is
    kept and reused.
    """
    folder, work = Path(folder), Path(work)
    if not folder.is_dir():
        raise UserError(f"{folder}: there is no such folder; give the folder that holds the captured frames.")
    if work.resolve().is_relative_to(folder.resolve()):
        raise UserError(f"{work}: lies inside the capture; give a work folder outside {folder}.")
    store = Store(work)
    existed = work.exists()
    store.create()
    with FolderLock(work) as lock, _pool(store, existed, workers, address) as pool:
        store.guard = lock.check
        store.clear_scratch()
        timings = Timings(work / "timings.json")
        try:
            capture = _read(store, pool, folder, options, progress, timings)
            choices = read_choices(work / CHOICES_FILE, capture, options.max_pairs)
            read = preview_capture(capture) if options.preview else capture
            matching = _match(store, pool, read, options, progress, timings)
            matching = _choose(store, pool, read, matching, options, progress, timings)
            candidates = chosen_candidates(choices, matching, capture, work / CHOICES_FILE)
            outcomes = _pairs(store, pool, read, candidates, choices, options, progress, timings)
            _graph(store, pool, capture, outcomes, options, progress, timings)
        except BaseException:
            pool.kill()  # before scratch is cleared, or workers would go on writing there
            if store.empty():
                store.withdraw(existed)
            else:
                with suppress(OSError):  # what went wrong counts, not that its times cannot be kept
                    timings.save()
            raise
        finally:
            shutil.rmtree(store.scratch, ignore_errors=True)
        with user_errors(work):
            timings.save()
        for name in store.damaged:
            progress.note(f"{name} was damaged and has been made again.")


def _pool(store: Store, existed: bool, workers: int, address: str | None) -> Pool | ClusterPool:
    """Workers that can do the work; where there are none, the folder is as it was."""
    try:
        pool = open_pool(workers, address)
        if isinstance(pool, ClusterPool):
            pool.check(store.root)
    except UserError:
        if store.empty():
            store.withdraw(existed)
        raise
    return pool


def _read(
    store: Store,
    pool: Pool | ClusterPool,
    folder: Path,
    options: BuildOptions,
    progress: StageProgress,
    timings: Timings,
) -> Capture:
    """Check every frame once. Here files are known by name, size and time, to resume fast; afterwards by content."""
    overrides: dict[str, Any] = {"fps": options.fps, "unit": options.unit, "up": options.up, "floor": options.floor}
    inputs = {
        "stage": "reading",
        "stage_version": VERSIONS["reading"],
        "folder": str(folder.resolve()),
        "files": _listing(folder),
        **overrides,
    }
    found = store.find("capture.json", inputs)
    if found is not None:
        return Capture.from_json(_json(found))
    progress.why("capture.json", store.why("capture.json", inputs))
    with progress.stage("reading frames") as advance, timings.wall("reading"), _worker_death("reading frames"):
        capture = open_capture(folder.resolve(), **overrides, executor=pool.executor, progress=advance)
    store.commit_json("capture.json", inputs, capture.to_json())
    return capture


def _match(
    store: Store,
    pool: Pool | ClusterPool,
    capture: Capture,
    options: BuildOptions,
    progress: StageProgress,
    timings: Timings,
) -> Matching:
    inputs = {
        "stage": "matching",
        "stage_version": VERSIONS["matching"],
        "frames": [[frame.clip, frame.number, frame_hash(capture, i)] for i, frame in enumerate(capture.frames)],
        "fps": capture.fps,
        "unit": capture.unit,
        "up": capture.up,
        "floor": capture.floor,
        "matching": asdict(options.matching),
        **preview_inputs(options),
    }
    found = store.find("matching", inputs)
    if found is not None:
        return read_matching(found)
    progress.why("matching", store.why("matching", inputs))
    scratch = store.new_scratch()
    with progress.stage("matching windows") as advance, timings.wall("matching"), _worker_death("matching windows"):
        with user_errors(store.root):
            matching = match(capture, options.matching, scratch=scratch, executor=pool.executor, progress=advance)
    made = store.new_scratch()
    with user_errors(store.root):
        write_matching(matching, made)
        shutil.rmtree(scratch)
    store.commit("matching", inputs, made)
    # What is in the store is what counts: a resumed run reads this, so this run does too.
    return read_matching(store.path("matching"))


def _choose(
    store: Store,
    pool: Pool | ClusterPool,
    capture: Capture,
    matching: Matching,
    options: BuildOptions,
    progress: StageProgress,
    timings: Timings,
) -> Matching:
    """The matching with the candidates of the wanted construction."""
    name = options.graph.construction
    if name == GraphOptions.construction:
        return matching
    inputs = {
        "stage": "candidates",
        "stage_version": VERSIONS["candidates"],
        "matching": (store.manifest("matching") or {}).get("key"),
        "graph": asdict(options.graph),
    }
    if store.find("candidates.json", inputs) is None:
        with progress.stage("choosing transitions"), timings.wall("candidates"), _worker_death("choosing transitions"):
            choose = CONSTRUCTIONS[name].choose
            found = choose(capture, matching, options.matching, options.graph, pool.executor)
        store.commit_json("candidates.json", inputs, [asdict(candidate) for candidate in found])
    return replace(matching, candidates=read_candidates(store.path("candidates.json"), len(capture)))


def _pairs(
    store: Store,
    pool: Pool | ClusterPool,
    capture: Capture,
    candidates: tuple[Candidate, ...],
    choices: Choices,
    options: BuildOptions,
    progress: StageProgress,
    timings: Timings,
) -> list[Outcome]:
    loop = PairLoop(store, pool, capture, options, timings.items, choices, progress.why)
    with progress.stage("tracking and synthesis") as advance:
        outcomes = loop.run(candidates, advance)
    wanted = {
        name
        for o in outcomes
        for group in ("cages", "pairs", "transitions")
        for name in loop.artefacts(o.candidate, group)
    }
    wanted |= {name.replace("transitions/", "pictures/", 1) for name in wanted}
    for group in ("cages", "pairs", "transitions", "pictures"):
        for name in store.names(group):
            if name not in wanted:
                store.remove(name)
    rows = [_outcome_row(capture, outcome) for outcome in outcomes]
    rules = {"matching": asdict(options.matching), "synthesis": asdict(options.synthesis)}
    store.commit_json("outcomes.json", {"stage": "outcomes", "stage_version": VERSIONS["outcomes"], **rules}, rows)
    return outcomes


def _graph(
    store: Store,
    pool: Pool | ClusterPool,
    capture: Capture,
    outcomes: list[Outcome],
    options: BuildOptions,
    progress: StageProgress,
    timings: Timings,
) -> None:
    with _worker_death("places on the floor"):
        places = captured_places(store, pool, capture, progress, timings)
    kept = [outcome.candidate for outcome in outcomes if outcome.refusal is None]
    ways = [(s, t, pair) for pair in kept for s, t in ((pair.source, pair.target), (pair.target, pair.source))]
    names = [pair_name(capture, s, t, "transitions") for s, t, _ in ways]
    inputs = {
        "stage": "graph",
        "stage_version": VERSIONS["graph"],
        "graph": asdict(options.graph),
        "fps": capture.fps,
        "frames": [capture.frame_id(index) for index in range(len(capture))],
        "places": (store.manifest("places.json") or {}).get("key"),
        "transitions": [
            [name, (store.manifest(name) or {}).get("key"), pair.score]
            for name, (_, _, pair) in zip(names, ways, strict=True)
        ],
    }
    if store.find("graph.json", inputs) is not None:
        return
    progress.why("graph.json", store.why("graph.json", inputs))
    links, cards, steps = [], {}, []
    for name, (s, t, pair) in zip(names, ways, strict=True):
        folder = store.path(name)
        alignment, card = read_card(folder)
        links.append(Link(s, t, pair.k, alignment, pair.score, _ends(pair, s != pair.source)))
        steps.append(read_floor_centres(folder))
        cards[s, t] = card
    with progress.stage("graph and probabilities"), timings.wall("graph"):
        graph = build_graph(capture, links, options.graph, Places(places, tuple(steps)))
    store.commit_json("graph.json", inputs, graph_to_json(graph, capture, cards))


def _ends(candidate: Candidate, reverse: bool) -> tuple[int, int] | None:
    """The frames that one direction of a warped pair leaves and arrives at."""
    if candidate.warp is None:
        return None
    leaving, meeting = candidate.warp[::-1] if reverse else candidate.warp
    return leaving[0], meeting[-1]


def _outcome_row(capture: Capture, outcome: Outcome) -> dict[str, Any]:
    candidate, refusal = outcome.candidate, outcome.refusal
    return {
        "source": capture.frame_id(candidate.source),
        "target": capture.frame_id(candidate.target),
        "score": candidate.score,
        "yaw": candidate.yaw,
        "k": candidate.k,
        "warp": None if candidate.warp is None else [list(map(capture.frame_id, way)) for way in candidate.warp],
        "status": "kept" if refusal is None else "refused",
        "refusal": None if refusal is None else asdict(refusal),
    }


def _listing(folder: Path) -> list[list[Any]]:
    """Name, size and time of every file of the capture, sorted."""
    with user_errors(folder):
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        return [[p.relative_to(folder).as_posix(), p.stat().st_size, p.stat().st_mtime_ns] for p in files]


def _json(path: Path) -> Any:
    return json.loads(path.read_text())


@contextmanager
def _worker_death(stage: str) -> Iterator[None]:
    try:
        yield
    except BrokenExecutor:
        raise UserError(
            f"{stage}: a worker process died, most likely for want of memory; run again with fewer --workers."
        ) from None
