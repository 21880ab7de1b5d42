"""A walk, a path or a plain capture as files of another program's format."""

from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future, wait
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.progress import Progress
from unstructured_mg.errors import UserError
from unstructured_mg.playback.decimated import decimated_frames, decimated_transitions
from unstructured_mg.playback.export_format import ExportFrame, Format, Target
from unstructured_mg.playback.export_glb import GLB
from unstructured_mg.playback.export_mp4 import MP4
from unstructured_mg.playback.export_obj import OBJ
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.export_ply import PLY, UNITY
from unstructured_mg.playback.export_usd import USD
from unstructured_mg.playback.showing import shown_frames
from unstructured_mg.playback.smaller_texture import smaller_texture
from unstructured_mg.playback.stream import LoadTransition, PosedFrame, posed_frames
from unstructured_mg.playback.walk import Walk
from unstructured_mg.playback.walk_json import walk_text, walk_to_json
from unstructured_mg.playback.whole_folder import whole_folder
from unstructured_mg.playback.world import ExportSpace, export_space

FORMATS = {each.name: each for each in (OBJ, PLY, UNITY, GLB, USD, MP4)}
WAITING = 16  # frames that may be on their way to the workers: enough to keep them busy, few enough to hold in memory


def find_format(options: ExportOptions) -> Format:
    """The format that is asked for. UserError where there is none of that name, or an option means nothing to it."""
    if options.format not in FORMATS:
        raise UserError(f"--format {options.format}: there is no such format; give one of {', '.join(FORMATS)}.")
    found = FORMATS[options.format]
    unused = dict(found.unused)
    if found.space is not None:
        up, unit = found.space
        unused = dict.fromkeys(("up", "unit"), f"it is always {up} up, {unit:g} m a unit") | unused
    if not found.pictures:
        unused |= dict.fromkeys(("camera", "picture_height"), "it is no video")
    for name in options.given():
        if name in unused:
            word = name.replace("_", "-")
            raise UserError(f"--{word}: the format {found.name} has no use for it ({unused[name]}); leave it out.")
    if options.up is not None and options.up not in found.axes:
        raise UserError(f"--up {options.up}: the format {found.name} knows {' and '.join(found.axes)} only.")
    if found.require is not None:
        found.require()
    return found


def export_walk(
    walk: Walk,
    capture: Capture,
    load_transition: LoadTransition | None,
    out: Path,
    options: ExportOptions | None = None,
    *,
    force: bool = False,
    inputs: Mapping[str, str] | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> int:
    """Write a walk and ``walk.json`` into a new folder ``out``; how many frames it shows.

    The folder appears when it is complete: all is written into a folder beside it, which is then renamed. Frames are
    read one at a time, and few are in memory at once.

    Parameters
    ----------
    walk : of a motion graph, or ``capture_walk(capture)``: the captured frames as they are
    load_transition : gives a transition for (source, target) frame indices; None where the walk shows none
    force : replace ``out`` where all that it holds are files of exports
    inputs : what the walk was made from, for walk.json (name to content hash)
    executor : where given, frames are prepared or written by its workers; the result is the same

    Raises
    ------
    UserError
        Where the format is not known, a program or package that it needs is not there, an option means nothing to it,
        or ``out`` is taken or cannot be written; nothing is left behind.
    """
    options = ExportOptions() if options is None else options
    found = find_format(options)
    up = options.up or (capture.up if capture.up in found.axes else found.axes[0])
    space = export_space(capture, *(found.space or (up, options.unit)))
    fps = options.fps or capture.fps
    shown = replace(walk, frames=tuple(walk.frames[i] for i in shown_frames(len(walk), capture.fps, options)))
    every = "|".join(["walk\\.json", *(each.files for each in FORMATS.values())])
    with whole_folder(out, every, force) as folder:
        target = Target(folder, len(shown), fps, options.first_number, space, options)
        frames = _frames(_posed(shown, capture, load_transition, options.decimate), space)
        if found.measure is not None and found.plan is not None:
            distinct = {frame.content: frame for frame in reversed(shown.frames)}
            looked_at = _frames(posed_frames(distinct.values(), capture, load_transition), space)
            measured = dict(zip(distinct, _in_order(found.measure, looked_at, executor), strict=True))
            worlds = [space.world(frame.world) for frame in shown.frames]
            views = found.plan([measured[frame.content] for frame in shown.frames], worlds, target)
            frames = (replace(frame, view=view) for frame, view in zip(frames, views, strict=True))
        prepared = _in_order(partial(_prepare, found, target), frames, executor)
        try:
            files = found.collect(_told(prepared, len(shown), progress), target)
        finally:
            prepared.close()
        text = walk_text(walk_to_json(shown, capture, space, files, inputs, fps, options.given()))
        (folder / "walk.json").write_text(text, encoding="utf-8")
    return len(shown)


def _posed(
    walk: Walk, capture: Capture, load_transition: LoadTransition | None, most_faces: int | None
) -> Iterator[PosedFrame]:
    if most_faces is None:
        return posed_frames(walk, capture, load_transition)
    load = None if load_transition is None else decimated_transitions(load_transition, most_faces)
    return decimated_frames(posed_frames(walk, capture, load), capture, most_faces)


def _frames(frames: Iterator[PosedFrame], space: ExportSpace) -> Iterator[ExportFrame]:
    for number, frame in enumerate(frames):
        yield ExportFrame(
            number=number,
            key=frame.origin.content,
            own_vertices=space.points(frame.own_vertices),
            world=space.world(frame.origin.world),
            faces=frame.faces,
            uv=frame.uv,
            face_uv=frame.face_uv,
            face_material=frame.face_material,
            colors=frame.colors,
            textures=frame.textures,
        )


def _prepare(found: Format, target: Target, frame: ExportFrame) -> Any:
    """Runs in workers."""
    if target.options.texture_size is not None:
        textures = tuple(smaller_texture(texture, target.options.texture_size) for texture in frame.textures)
        frame = replace(frame, textures=textures)
    return found.prepare(frame, target)


def _in_order(
    work: Callable[[ExportFrame], Any], frames: Iterable[ExportFrame], executor: Executor | None
) -> Generator[Any]:
    """What ``work`` makes of each frame, in order, made by the executor's workers where there are any."""
    waiting: deque[Future[Any]] = deque()
    try:
        for frame in frames:
            if executor is None:
                yield work(frame)
                continue
            waiting.append(executor.submit(work, frame))
            if len(waiting) > WAITING:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:  # a worker that still writes would put files back into a folder that is being removed
        for future in waiting:
            future.cancel()
        wait(waiting)


def _told(items: Iterable[Any], count: int, progress: Progress | None) -> Iterator[Any]:
    """The same items; each is done when the next one is asked for."""
    for done, item in enumerate(items, start=1):
        yield item
        if progress is not None:
            progress(done, count)
