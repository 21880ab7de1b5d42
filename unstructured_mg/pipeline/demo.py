"""``umg demo``: the whole road on the procedural capture."""

import os
import shutil
from pathlib import Path

from rich.console import Console

from unstructured_mg.capture.procedural import write_procedural
from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.build import build
from unstructured_mg.pipeline.export import export_work
from unstructured_mg.pipeline.options import BuildOptions
from unstructured_mg.pipeline.pool import Pool
from unstructured_mg.pipeline.progress import StageProgress
from unstructured_mg.pipeline.reporting import make_report
from unstructured_mg.pipeline.site import make_site
from unstructured_mg.pipeline.store import user_errors
from unstructured_mg.pipeline.summary import print_summary
from unstructured_mg.pipeline.work import open_work
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.site_options import SiteOptions
from unstructured_mg.playback.walk import random_walk

# Enough for a graph that covers the actions, and few enough for about three minutes on two cores.
PAIRS = 6
WALK_FRAMES = 300
WALK_SEED = 1
OURS = {"capture", "capture.partial", "work", "walk", "site"}


def run_demo(folder: Path, workers: int, console: Console) -> None:
    """Write the procedural capture, build its graph, export a walk, the report and the web page, all in ``folder``."""
    progress = StageProgress(console)
    capture, work = folder / "capture", folder / "work"
    with user_errors(folder):
        folder.mkdir(parents=True, exist_ok=True)
        if any(path.name not in OURS for path in folder.iterdir()):
            raise UserError(f"{folder}: holds other files than a demo's; give a new or empty folder.")
        if not capture.exists():
            partial = folder / "capture.partial"
            shutil.rmtree(partial, ignore_errors=True)
            with Pool(workers) as pool, progress.stage("making the demo's capture") as advance:
                write_procedural(partial, executor=pool.executor, progress=advance)
            os.replace(partial, capture)
    build(capture, work, BuildOptions(max_pairs=PAIRS), workers, progress)
    opened = open_work(work)
    print_summary(opened, console)
    walk = random_walk(opened.graph, opened.capture, WALK_FRAMES, WALK_SEED)
    export_work(opened, walk, folder / "walk", ExportOptions(), True, workers, progress)
    report = make_report(work, None, workers, progress)
    console.print(f"\nA walk of {WALK_FRAMES} frames: {folder / 'walk'} (OBJ sequence, opens in Blender and others)")
    make_site(opened, folder / "site", SiteOptions(), True, workers, progress)
    page = folder / "site" / "index.html"
    console.print(f"The report, to open in a browser: {report.resolve().as_uri()}", soft_wrap=True)
    console.print(f"The page that plays on for ever: {page.resolve().as_uri()}", soft_wrap=True)
