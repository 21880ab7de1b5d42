"""The command line: each subcommand is one thin call."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

from unstructured_mg.pipeline.pool import single_thread

single_thread()  # before NumPy comes in with the rooms

from concurrent.futures.process import BrokenProcessPool  # noqa: E402

from cyclopts import App, CycloptsError, Parameter, validators  # noqa: E402
from rich.console import Console  # noqa: E402

from unstructured_mg import __version__  # noqa: E402
from unstructured_mg.errors import UserError  # noqa: E402

if TYPE_CHECKING:
    from unstructured_mg.pipeline.work import Work
    from unstructured_mg.playback.export_options import ExportOptions
    from unstructured_mg.playback.walk import Walk

app = App(
    name="umg",
    suppress_keyboard_interrupt=False,
    help="Motion graphs for unstructured textured meshes: a captured folder in, endless seamless performance out.",
    version=__version__,
    help_format="markdown",
)

Output = Annotated[Path, Parameter(name=["--output", "-o"])]
AtLeastOne = validators.Number(gte=1)
Positive = validators.Number(gt=0, lt=float("inf"))
Workers = Annotated[int | None, Parameter(validator=AtLeastOne)]
Flag = Annotated[bool, Parameter(negative=())]


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class Export:
    """What every subcommand that exports frames takes.

    Attributes
    ----------
    output
        A new or empty folder.
    force
        Replace an earlier export in the output folder.
    format
        What to write: obj (OBJ + MTL + image files), ply, unity (for Geometry Sequence Player), glb, usd or mp4.
    fps
        Frames a second; the capture's own unless given. The motion keeps its speed.
    first_number
        The number in the first file's name.
    bounce
        Play there and back again, so that the end joins the beginning.
    hold
        Hold the last frame (with --bounce the first one too) for so many frames more.
    up
        The up axis: x, y or z, with a minus where it points down; the capture's own unless given.
    unit
        The unit (m, dm, cm, mm, inch, foot, or metres as a number); the capture's own unless given.
    decimate
        At most so many faces a frame, as far as the texture's seams allow.
    texture_size
        At most so many pixels along a texture's longer side.
    camera
        Of mp4: fixed (sees the whole walk) or orbit (goes around the figure).
    picture_height
        Of mp4, in pixels.
    workers
        Worker processes; as many as there are cores unless given.
    """

    output: Output
    force: Flag = False
    format: str = "obj"
    fps: float | None = None
    first_number: int = 1
    bounce: Flag = False
    hold: int = 0
    up: str | None = None
    unit: str | None = None
    decimate: int | None = None
    texture_size: int | None = None
    camera: str = "fixed"
    picture_height: int = 720
    workers: Workers = None

    def options(self) -> "ExportOptions":
        """The same, checked. A value that is no good is a UserError."""
        from unstructured_mg.pipeline.options import export_options
        from unstructured_mg.playback.export import find_format

        options = export_options(
            self.fps,
            self.unit,
            self.up,
            format=self.format,
            first_number=self.first_number,
            bounce=self.bounce,
            hold=self.hold,
            decimate=self.decimate,
            texture_size=self.texture_size,
            camera=self.camera,
            picture_height=self.picture_height,
        )
        find_format(options)
        return options


@app.command
def inspect(
    capture: Path,
    /,
    *,
    fps: float | None = None,
    unit: str | None = None,
    up: str | None = None,
    floor: float | None = None,
    json: Path | None = None,
    workers: Workers = None,
) -> None:
    """Show what a capture holds and everything that is wrong with it, frame by frame.

    Parameters
    ----------
    capture
        The folder with the captured frames (or with one folder a clip).
    fps
        Frames a second, where the capture does not say it.
    unit
        The capture's unit (m, dm, cm, mm, inch, foot, or metres as a number), in place of what is detected.
    up
        The capture's up axis: x, y or z, with a minus where it points down.
    floor
        Height of the floor along the up axis, in the capture's unit.
    json
        Write the findings to this file as well.
    workers
        Worker processes; as many as there are cores unless given.
    """
    from unstructured_mg.capture.inspect import inspect_capture
    from unstructured_mg.capture.inspect_text import inspection_renderable
    from unstructured_mg.capture.reader import open_capture
    from unstructured_mg.pipeline.options import capture_options
    from unstructured_mg.pipeline.pool import Pool
    from unstructured_mg.pipeline.progress import StageProgress

    given = capture_options(fps, unit, up, floor)
    console = Console()
    progress = StageProgress(console)
    with Pool(workers or _cores()) as pool:
        with progress.stage("reading frames") as advance:
            opened = open_capture(capture, **given, executor=pool.executor, progress=advance)
        with progress.stage("inspecting frames") as advance:
            inspection = inspect_capture(opened, executor=pool.executor, progress=advance)
    console.print(inspection_renderable(inspection))
    if json is not None:
        from json import dumps

        from unstructured_mg.pipeline.store import user_errors

        with user_errors(json):
            json.write_text(dumps(inspection.to_json(), indent=1) + "\n")


@app.command
def build(
    capture: Path,
    /,
    *,
    output: Output,
    fps: float | None = None,
    unit: str | None = None,
    up: str | None = None,
    floor: float | None = None,
    descriptor: str | None = None,
    rank: int | None = None,
    window: Annotated[int, Parameter(validator=validators.Number(gte=2))] = 10,
    windows: str | None = None,
    largest_window: int | None = None,
    threshold: float | None = None,
    velocity: float | None = None,
    colour: float | None = None,
    cage: str | None = None,
    hausdorff: float | None = None,
    blend: str | None = None,
    weights: str | None = None,
    texture: str | None = None,
    graph: str | None = None,
    probabilities: str | None = None,
    visit: Annotated[tuple[str, ...] | None, Parameter(negative=())] = None,
    max_pairs: Annotated[int | None, Parameter(validator=AtLeastOne)] = None,
    preview: Flag = False,
    why: Flag = False,
    dask: str | None = None,
    workers: Workers = None,
) -> None:
    """Build a motion graph, or finish building it: run the same command again after any interruption.

    Parameters
    ----------
    capture
        The folder with the captured frames (or with one folder a clip).
    output
        The work folder: new, empty, or an earlier build's.
    fps
        Frames a second, where the capture does not say it.
    unit
        The capture's unit (m, dm, cm, mm, inch, foot, or metres as a number), in place of what is detected.
    up
        The capture's up axis: x, y or z, with a minus where it points down.
    floor
        Height of the floor along the up axis, in the capture's unit.
    descriptor
        What frames are compared by: cylindrical_edt, shape_histogram, or deformation_gradients (one connectivity only).
    rank
        For long captures: compare frames by so many numbers a frequency, within an error that is stated.
    window
        Half window k: transitions are 2k + 1 frames long, ends included. Of adaptive windows, the smallest.
    windows
        fixed, or adaptive: every pair gets the length at which it fits best.
    largest_window
        Of adaptive windows, the largest half window; twice the smallest unless given.
    threshold
        Candidates differ by at most this: a share of the actor's size, or in the units of the descriptor.
    velocity
        Seconds over which a difference of the root's velocity counts as distance; 0 leaves it out.
    colour
        Metres that the largest difference of a colour channel counts for; not at all unless given.
    cage
        The tetrahedral cage around a template: lattice (repeats exactly) or tetwild.
    hausdorff
        Refuse pairs whose template strays further than this from a captured surface, in metres.
    blend
        How the geometry of both windows is blended: volumetric_arap, surface_arap, poisson,
        linear or latent (learnt for each pair; needs torch).
    weights
        The blend's course over time: cubic or linear.
    texture
        How the texture gets from one window's to the other's: flow, crossfade or none.
    graph
        Which transitions are made: local_windows (the best pairs of windows), essential (what the cheapest ways between
        all frames need, of variable length) or surface (the best one between any two clips).
    probabilities
        How random walks choose: choice (as evenly as possible) or entropy (as unpredictably as possible), both so that
        frames are visited as often as is wanted of them.
    visit
        CLIP=WEIGHT, FRAME=WEIGHT or FRAME..FRAME=WEIGHT: how often these are wanted in random walks, where others have
        weight 1. May be given several times; only the graph is made again.
    max_pairs
        Keep at most so many pairs.
    preview
        Build fast, to judge which pairs there are and how they move: decimated frames, small textures that only fade.
    why
        Tell for everything that is made why it is: not made yet, damaged, or which input or option has changed.
    dask
        Address of a Dask scheduler (tcp://host:8786) whose workers do the work, in place of processes here. Capture and
        output lie where all of them see them under the same path.
    workers
        Worker processes; as many as there are cores unless given.
    """
    from unstructured_mg.pipeline.build import build as run
    from unstructured_mg.pipeline.options import build_options, capture_options
    from unstructured_mg.pipeline.preview import preview_options
    from unstructured_mg.pipeline.progress import StageProgress
    from unstructured_mg.pipeline.summary import print_summary
    from unstructured_mg.pipeline.work import open_work

    options = build_options(
        **capture_options(fps, unit, up, floor),
        descriptor=descriptor,
        rank=rank,
        window=window,
        windows=windows,
        largest_window=largest_window,
        threshold=threshold,
        velocity=velocity,
        colour=colour,
        cage=cage,
        hausdorff=hausdorff,
        blend=blend,
        weights=weights,
        texture=texture,
        graph=graph,
        probabilities=probabilities,
        visit=visit,
        max_pairs=max_pairs,
    )
    if preview:
        if texture == "flow":
            raise UserError("--texture: flow is not for a --preview, whose textures only fade; leave one of them out.")
        options = preview_options(options)
    console = Console()
    if dask is not None and workers is not None:
        raise UserError("--workers: with --dask its own workers do the work; leave one of them out.")
    run(capture, output, options, workers or _cores(), StageProgress(console, why), dask)
    print_summary(open_work(output), console)


@app.command
def status(work: Path, /) -> None:
    """Show what a work folder holds, what of it is damaged, and who is writing there. Nothing is changed.

    Parameters
    ----------
    work
        The work folder of a build, finished or not.
    """
    from unstructured_mg.pipeline.status import print_status, work_status

    print_status(work_status(work), Console())


@app.command
def clean(work: Path, /, *, dry_run: Flag = False) -> None:
    """Free the space of what walks and reports do not need: tracked pairs, the report's pictures, leftovers.

    Parameters
    ----------
    work
        The work folder of a build.
    dry_run
        Only tell what would go.
    """
    from unstructured_mg.pipeline.clean import clean as run
    from unstructured_mg.pipeline.clean import print_cleaning

    print_cleaning(run(work, dry_run), dry_run, Console())


@app.command
def walk(
    work: Path,
    /,
    *,
    frames: Annotated[int, Parameter(validator=AtLeastOne)],
    seed: Annotated[int, Parameter(validator=validators.Number(gte=0, lt=2**32))] = 0,
    start: str | None = None,
    export: Export,
) -> None:
    """Export a random walk with walk.json, which says where every frame comes from.

    Parameters
    ----------
    work
        The work folder of a finished build.
    frames
        How many frames to export.
    seed
        The same seed gives the same walk.
    start
        Id of the captured frame to start at; the graph's first frame unless given.
    """
    from unstructured_mg.pipeline.work import open_work
    from unstructured_mg.playback.walk import random_walk

    options = export.options()
    opened = open_work(work)
    begin = None if start is None else opened.capture.index_of(start)
    found = random_walk(opened.graph, opened.capture, frames, seed, begin)
    _export(opened, found, export, options)


@app.command
def path(
    work: Path,
    /,
    *,
    from_: Annotated[str | None, Parameter(name="--from")] = None,
    to: str | None = None,
    frames: Annotated[int | None, Parameter(validator=AtLeastOne)] = None,
    seconds: Annotated[float | None, Parameter(validator=Positive)] = None,
    distance: Annotated[float | None, Parameter(validator=Positive)] = None,
    curve: Path | None = None,
    poses: Path | None = None,
    loop: Flag = False,
    within: Annotated[float | None, Parameter(validator=Positive)] = None,
    export: Export,
) -> None:
    """Export a path between captured frames with walk.json, which says where every frame comes from.

    Without constraints it is the shortest. Constraints that cannot be met give the nearest path and say what it misses.

    Parameters
    ----------
    work
        The work folder of a finished build.
    from_
        Id of the first captured frame.
    to
        Id of the last captured frame.
    frames
        How many frames to show, the first and last included (of a loop: in one round).
    seconds
        The same in seconds.
    distance
        Metres to travel over the floor; with --frames or --seconds the two are weighed (30 cm against 10 frames).
    curve
        A file with the floor curve to follow: a line for each point, x and y in metres. --from may be left out.
    poses
        A file with frames to pass through and when: a line for each, seconds and a frame's id.
    loop
        Back to the first frame, to be played again and again; --from may be left out where a length is given.
    within
        Metres that the path may get away from where it begins; needs --frames or --seconds.
    """
    from unstructured_mg.pipeline.requests import path_request
    from unstructured_mg.pipeline.work import open_work
    from unstructured_mg.playback.walk import path_walk

    options = export.options()
    opened = open_work(work)
    request = path_request(
        opened.capture,
        start=from_,
        goal=to,
        frames=frames,
        seconds=seconds,
        distance=distance,
        curve=curve,
        poses=poses,
        loop=loop,
        within=within,
    )
    _export(opened, path_walk(opened.graph, opened.capture, request), export, options)


@app.command
def convert(
    capture: Path,
    /,
    *,
    capture_fps: float | None = None,
    capture_unit: str | None = None,
    capture_up: str | None = None,
    capture_floor: float | None = None,
    export: Export,
) -> None:
    """Export a capture's frames as they are, whatever format they come in, with walk.json.

    Parameters
    ----------
    capture
        The folder with the captured frames (or with one folder a clip).
    capture_fps
        Frames a second of the capture, where it does not say it.
    capture_unit
        The capture's unit, in place of what is detected.
    capture_up
        The capture's up axis, in place of what is detected.
    capture_floor
        Height of the capture's floor along its up axis, in its unit.
    """
    from unstructured_mg.capture.reader import open_capture
    from unstructured_mg.pipeline.export import export_capture
    from unstructured_mg.pipeline.options import capture_options
    from unstructured_mg.pipeline.pool import Pool
    from unstructured_mg.pipeline.progress import StageProgress

    options = export.options()
    given = capture_options(capture_fps, capture_unit, capture_up, capture_floor, prefix="--capture-")
    workers, progress = export.workers or _cores(), StageProgress(Console())
    with Pool(workers) as pool, progress.stage("reading frames") as advance:
        opened = open_capture(capture, **given, executor=pool.executor, progress=advance)
    count = export_capture(opened, export.output, options, export.force, workers, progress)
    if opened.faults:
        print(f"{len(opened.faults)} frames cannot be used and are left out: umg inspect {capture} says why")
    print(f"{count} frames are in {export.output}")


@app.command
def report(work: Path, /, *, output: Output | None = None, workers: Workers = None) -> None:
    """Write one HTML page with the matrix, the timeline, the probabilities and every transition's contact sheet.

    Parameters
    ----------
    work
        The work folder of a finished build.
    output
        The file to write; WORK/report.html unless given.
    workers
        Worker processes; as many as there are cores unless given.
    """
    from unstructured_mg.pipeline.progress import StageProgress
    from unstructured_mg.pipeline.reporting import make_report

    written = make_report(work, output, workers or _cores(), StageProgress(Console()))
    print(f"the report is {written}")


@app.command
def web(
    folder: Path,
    /,
    *,
    output: Output | None = None,
    force: Flag = False,
    serve: Flag = False,
    port: Annotated[int | None, Parameter(validator=validators.Number(gte=1, lte=65535))] = None,
    decimate: Annotated[int | None, Parameter(validator=validators.Number(gte=4))] = None,
    texture_size: Annotated[int, Parameter(validator=validators.Number(gte=16, lte=8192))] = 1024,
    quality: Annotated[int, Parameter(validator=validators.Number(gte=1, lte=100))] = 80,
    workers: Workers = None,
) -> None:
    """Write a web page that plays the motion graph: a folder that any file server can serve, or that opens as it is.

    Parameters
    ----------
    folder
        The work folder of a finished build; or, with --serve and without -o, a page's folder.
    output
        A new or empty folder for the page.
    force
        Replace an earlier page in the output folder.
    serve
        Serve the page on 127.0.0.1, for this machine only, until Ctrl-C.
    port
        The port to serve on; a free one unless given.
    decimate
        At most so many faces a frame, as far as the texture's seams allow.
    texture_size
        At most so many pixels along an image's longer side.
    quality
        Of the images (WebP), 1 to 100.
    workers
        Worker processes; as many as there are cores unless given.
    """
    from unstructured_mg.pipeline.progress import StageProgress
    from unstructured_mg.pipeline.site import make_site, serve_site
    from unstructured_mg.pipeline.work import open_work
    from unstructured_mg.playback.site_options import SiteOptions

    if output is None and not serve:
        raise UserError("say where to write the page with -o SITE, or serve one with umg web SITE --serve.")
    if port is not None and not serve:
        raise UserError("--port: says where to serve; give --serve too.")
    options = SiteOptions(texture_size=texture_size, quality=quality, decimate=decimate)
    if output is None:
        if force or options != SiteOptions():
            raise UserError(
                "--force, --decimate, --texture-size, --quality: say how to write a page; give -o SITE too."
            )
    else:
        make_site(open_work(folder), output, options, force, workers or _cores(), StageProgress(Console()))
        print(f"the page is {(output / 'index.html').resolve().as_uri()}")
    if serve:
        serve_site(output or folder, port or 0)


@app.command
def view(
    work: Path,
    /,
    *,
    seed: Annotated[int, Parameter(validator=validators.Number(gte=0, lt=2**32))] = 1,
) -> None:
    """Play the motion graph in a window: an endless walk that keys and clicks direct.

    Parameters
    ----------
    work
        The work folder of a finished build.
    seed
        Of the walk that it begins with.
    """
    from unstructured_mg.pipeline.work import open_work
    from unstructured_mg.playback.viewer import Viewer, require_display

    opened = open_work(work)
    require_display()
    Viewer(opened.graph, opened.capture, opened.load_transition, seed).run()


@app.command
def demo(folder: Path, /, *, workers: Workers = None) -> None:
    """Build the package's own capture, walk through it, report, and write the web page, all in one folder.

    Parameters
    ----------
    folder
        A new or empty folder, or an earlier demo's.
    workers
        Worker processes; as many as there are cores unless given.
    """
    from unstructured_mg.pipeline.demo import run_demo

    run_demo(folder, workers or _cores(), Console())


def main() -> None:
    """Run the command line; what the user must mend ends it with one sentence and exit code 2."""
    try:
        app(exit_on_error=False, print_error=False)
    except CycloptsError as error:
        error.verbose = False  # its text for users, without the place in our code
        _fail(f"{' '.join(str(error).split()).rstrip('.')}; see {_usage(error)}.")
    except UserError as error:
        _fail(str(error))
    except BrokenProcessPool:
        _fail("a worker process died, most likely for want of memory; run again with fewer --workers.")
    except MemoryError:
        _fail("there is not enough memory; close other programs, or run again with fewer --workers.")
    except KeyboardInterrupt:
        print("umg: stopped; run the same command again to go on where it stopped.", file=sys.stderr)
        sys.exit(130)


def _fail(sentence: str) -> NoReturn:
    print(f"umg: {sentence}", file=sys.stderr)
    sys.exit(2)


def _usage(error: CycloptsError) -> str:
    """The command that explains what was asked for in vain."""
    return " ".join(["umg", *(error.command_chain or ()), "--help"])


def _export(work: "Work", walk: "Walk", export: Export, options: "ExportOptions") -> None:
    """Write a walk's frames and say what came of it."""
    from unstructured_mg.pipeline.export import export_work
    from unstructured_mg.pipeline.progress import StageProgress

    progress = StageProgress(Console())
    shown = export_work(work, walk, export.output, options, export.force, export.workers or _cores(), progress)
    for sentence in (walk.ended, walk.remark):
        if sentence:
            print(sentence)
    print(f"{shown} frames are in {export.output}")


def _cores() -> int:
    """The cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
