"""A capture and its motion graph as a static web page: a folder that any file server can serve."""

import json
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from importlib.resources import files
from pathlib import Path
from typing import Any

from unstructured_mg import __version__
from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.decimated import apply_decimation
from unstructured_mg.capture.progress import Progress
from unstructured_mg.geometry.decimate import decimate
from unstructured_mg.graph.files import graph_to_json
from unstructured_mg.graph.motion_graph import MotionGraph
from unstructured_mg.playback.conformance import conformance_walks
from unstructured_mg.playback.decimated import decimated_transition
from unstructured_mg.playback.facing import facing
from unstructured_mg.playback.plot_timeline import cost_colors
from unstructured_mg.playback.site_frame import frame_file
from unstructured_mg.playback.site_options import SiteOptions
from unstructured_mg.playback.site_transition import transition_file
from unstructured_mg.playback.walk import default_start
from unstructured_mg.playback.whole_folder import whole_folder
from unstructured_mg.synthesis.transition import Transition

FORMAT_VERSION = 1
OUR_FILES = r"index\.html|site\.js|walks\.json|player|frames|transitions"
# Files that may be on their way from the workers: enough to keep them busy, few enough to hold in memory.
WAITING = 16


def export_site(
    graph: MotionGraph,
    capture: Capture,
    load_transition: Callable[[int, int], Transition],
    out: Path,
    *,
    options: SiteOptions | None = None,
    force: bool = False,
    inputs: Mapping[str, str] | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> None:
    """Write ``index.html``, ``site.js``, ``walks.json``, ``player/``, ``frames/`` and ``transitions/`` into ``out``.

    Parameters
    ----------
    load_transition : gives the transition for (source, target) frame indices; sent to the workers where there are any
    options : sizes and qualities
    force : replace ``out`` where it holds an earlier site
    inputs : what the site was made from, by content hash

    Raises
    ------
    UserError
        Where ``out`` is taken or cannot be written; nothing is left behind.
    """
    options = options or SiteOptions()
    links = [link for index, link in enumerate(graph.links) if index in graph.links_used()]
    with whole_folder(out, OUR_FILES, force) as folder:
        for part in ("player", "frames", "transitions"):
            (folder / part).mkdir()
        _copy_player(folder)
        jobs: list[tuple[Any, ...]] = [(_frame, capture, i, options) for i in range(len(capture))]
        jobs += [(_transition, capture, load_transition, link.source, link.target, options) for link in links]
        for done, (name, data) in enumerate(_made(jobs, executor), start=1):
            (folder / f"{name}.js").write_bytes(data)
            if progress is not None:
                progress(done, len(jobs))
        text = json.dumps(site_to_json(graph, capture, inputs), separators=(",", ":"), allow_nan=False)
        (folder / "site.js").write_text(f'umg.take("site",{text})\n', encoding="utf-8")
        walks = json.dumps(conformance_walks(graph, capture), indent=1) + "\n"
        (folder / "walks.json").write_text(walks, encoding="utf-8")


def site_to_json(graph: MotionGraph, capture: Capture, inputs: Mapping[str, str] | None = None) -> dict[str, Any]:
    """What the page must know before it reads any frame (docs/files.md, "A web page"); JSON-ready."""
    used = graph.links_used()
    colors = cost_colors([link.cost for link in graph.links])
    first = capture.read(int(default_start(graph, capture)))
    return {
        "format": "unstructured_mg site",
        "version": FORMAT_VERSION,
        "program": __version__,
        "title": capture.folder.name,
        "inputs": dict(inputs or {}),
        "facing": facing(first.vertices, first.faces),
        "start": capture.frame_id(default_start(graph, capture)),
        "frames": [
            {"id": capture.frame_id(i), "clip": frame.clip, "number": frame.number, "file": frame_path(capture, i)}
            for i, frame in enumerate(capture.frames)
        ],
        "files": [
            transition_path(capture, link.source, link.target) if index in used else None
            for index, link in enumerate(graph.links)
        ],
        "colors": colors,
        "graph": graph_to_json(graph, capture, {}),
    }


def frame_path(capture: Capture, index: int) -> str:
    """The file of a captured frame in the site, without its ending; a colon is not allowed in a name everywhere."""
    return f"frames/{_file_name(capture, index)}"


def transition_path(capture: Capture, source: int, target: int) -> str:
    """The file of a transition in the site, without its ending."""
    return f"transitions/{_file_name(capture, source)}-{_file_name(capture, target)}"


def _file_name(capture: Capture, index: int) -> str:
    return capture.frame_id(index).replace(":", "_")


def _copy_player(folder: Path) -> None:
    for item in sorted(files("unstructured_mg.playback").joinpath("web").iterdir(), key=lambda item: item.name):
        target = folder / item.name if item.name == "index.html" else folder / "player" / item.name
        target.write_bytes(item.read_bytes())


def _frame(capture: Capture, index: int, options: SiteOptions) -> tuple[str, bytes]:
    name, mesh = frame_path(capture, index), capture.read(index)
    if options.decimate is not None and len(mesh.faces) > options.decimate:
        goal = options.decimate
        found = decimate(mesh.vertices, mesh.faces, goal, mesh.uv, mesh.face_uv, mesh.face_material)
        mesh = apply_decimation(mesh, found)
    return name, frame_file(mesh, capture.frame_id(index), name, options)


def _transition(
    capture: Capture, load: Callable[[int, int], Transition], source: int, target: int, options: SiteOptions
) -> tuple[str, bytes]:
    name = transition_path(capture, source, target)
    ids = capture.frame_id(source), capture.frame_id(target)
    transition = load(source, target)
    if options.decimate is not None:
        transition = decimated_transition(transition, options.decimate)
    return name, transition_file(transition, *ids, name, options)


def _made(jobs: list[tuple[Any, ...]], executor: Executor | None) -> Iterator[tuple[str, bytes]]:
    """The jobs' results in order; with an executor a few of them are under way at any time."""
    if executor is None:
        for task, *arguments in jobs:
            yield task(*arguments)
        return
    waiting: list[Future[tuple[str, bytes]]] = []
    try:
        for task, *arguments in jobs:
            waiting.append(executor.submit(task, *arguments))
            if len(waiting) > WAITING:
                yield waiting.pop(0).result()
        while waiting:
            yield waiting.pop(0).result()
    finally:
        for future in waiting:
            future.cancel()
