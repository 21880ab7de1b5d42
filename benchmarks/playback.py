"""How fast the viewer and the web page play, what a page weighs, and whether memory stays flat.

Frames are the procedural capture's with 10,000 and 50,000 faces and one image of 1024 x 1024 each, played in a loop, or
with ``--work`` those of a finished build, walked through. The page runs in a headless Chromium that draws in software
(SwiftShader), the viewer off screen. Pictures that are shown are counted over some seconds of real time: the capture
has 30 a second. Processor time a picture is that of all processes together; on a busy machine it tells more.

Peers: for the viewer, the same window with every frame read when it is due; for the page's weight, the captured files.

    python benchmarks/playback.py [--quick] [--work WORK] [--decimate FACES] [--frames N] [--json FILE]
"""

import argparse
import json
import os
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from chromium import Tab, browser, family

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.procedural import write_procedural
from unstructured_mg.capture.reader import open_capture
from unstructured_mg.graph.motion_graph import MotionGraph, build_graph
from unstructured_mg.pipeline.work import open_work
from unstructured_mg.playback.director import Director
from unstructured_mg.playback.frame_ring import FrameRing
from unstructured_mg.playback.serve import site_server
from unstructured_mg.playback.site import export_site
from unstructured_mg.playback.site_options import SiteOptions
from unstructured_mg.playback.viewer import Viewer

WINDOW = (1280, 800)
# The page's panel takes some of its height: its picture then has 1280 x 800 pixels.
PAGE = (1280, 1135)
RATE = 30.0

Figure = dict[str, object]


def figure(name: str, value: float, unit: str, reach: float | None, holds: bool | None) -> Figure:
    return {"name": name, "value": round(float(value), 3), "unit": unit, "reach": reach, "holds": holds}


def rate_figure(name: str, rate: float, reach: float | None) -> Figure:
    """Pictures a second; a count over some seconds may miss one of thirty."""
    return figure(name, rate, "1/s", reach, None if reach is None else rate > 0.97 * reach)


def no_transition(source: int, target: int) -> Any:
    raise AssertionError("a capture without transitions plays none")


def processor_seconds(process: int) -> float:
    """Of a process and all that it started."""
    ticks = 0
    for each in family(process):
        try:
            stat = Path(f"/proc/{each}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        ticks += int(stat[11]) + int(stat[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def resident() -> float:
    """Megabytes of this process."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def viewer_rate(graph: MotionGraph, capture: Capture, load: Callable[..., Any], seconds: float) -> tuple[float, float]:
    """Pictures a second, and processor milliseconds a picture."""
    viewer = Viewer(graph, capture, load, off_screen=True, size=WINDOW)
    viewer.open()
    shown: set[int] = set()
    last = time.perf_counter()
    begun, spent = last + 1.0, 0.0
    while (now := time.perf_counter()) < begun + seconds:
        viewer.tick(now - last)
        last = now
        if now < begun:
            shown.clear()
            spent = time.process_time()
        key = viewer.director.index
        if viewer.shown is not None and key not in shown:
            shown.add(key)
            viewer.plotter.render_window.Render()
        else:
            time.sleep(0.001)
    spent = time.process_time() - spent
    viewer.close()
    return len(shown) / seconds, 1000 * spent / max(len(shown), 1)


def read_when_due_rate(
    graph: MotionGraph, capture: Capture, load: Callable[..., Any], seconds: float
) -> tuple[float, float]:
    """The same, each frame read when it is to be shown."""
    viewer = Viewer(graph, capture, load, off_screen=True, size=WINDOW)
    viewer.open()
    last = begun = time.perf_counter()
    spent, pictures = time.process_time(), 0
    while (now := time.perf_counter()) < begun + seconds:
        viewer.ring.close()
        viewer.ring = FrameRing(capture, load)
        viewer.ring.want = lambda coming: None if coming[1:] else FrameRing.want(viewer.ring, coming)  # type: ignore[method-assign]
        viewer.tick(now - last, wait=True)
        viewer.plotter.render_window.Render()
        last, pictures = now, pictures + 1
    spent = time.process_time() - spent
    viewer.close()
    return pictures / seconds, 1000 * spent / max(pictures, 1)


def viewer_memory(graph: MotionGraph, capture: Capture, load: Callable[..., Any], frames: int) -> tuple[float, float]:
    """Megabytes after a fifth of the frames, and after all: reading only, as the ring does for the window."""
    director, ring = Director(graph, capture), FrameRing(capture, load)
    director.loop = director.mode == "capture"
    early = 0.0
    for number in range(frames):
        ring.get(director.shown(), wait=True)
        ring.want(director.coming(12))
        director.advance(1 / capture.fps + 1e-9)
        if number == frames // 5:
            early = resident()
    ring.close()
    return early, resident()


def page_rate(tab: Tab, address: str, seconds: float) -> tuple[float, float, float, float]:
    """Seconds to the first picture; pictures a second; processor milliseconds a picture; pixels drawn a pixel."""
    tab.size(*PAGE)
    begun = time.perf_counter()
    tab.open(address)
    tab.wait("globalThis.umg?.page?.drawn")
    first = time.perf_counter() - begun
    time.sleep(6)  # a machine without a graphics card has found its fineness by then
    counted, at = tab.evaluate("[umg.page.pictures, performance.now()]")
    spent = processor_seconds(tab.process)
    time.sleep(seconds)
    after, until = tab.evaluate("[umg.page.pictures, performance.now()]")
    spent = processor_seconds(tab.process) - spent
    pictures = max(after - counted, 1)
    fineness = tab.evaluate("umg.page.picture.fineness")
    return first, 1000 * pictures / (until - at), 1000 * spent / pictures, fineness**2


def page_memory(tab: Tab, frames: int) -> tuple[float, float, float, float]:
    """Megabytes of the browser and of its script heap, after a fifth of the frames and after all."""
    tab.evaluate("umg.page.player.play(false)")
    told = []
    for stop in (frames // 5, frames):
        start = 0 if stop != frames else frames // 5
        for first in range(start, stop, 200):
            last = min(first + 200, stop)
            tab.evaluate(
                f"(async () => {{ const {{ page }} = umg, {{ reel }} = page.player;"
                f" for (let i = {first}; i < {last}; i++) await page.show(reel.ended ? i % reel.known : i); }})()"
            )
        tab.command("HeapProfiler.collectGarbage")
        told += [tab.resident_bytes() / 1e6, tab.command("Runtime.getHeapUsage")["usedSize"] / 1e6]
    return told[0], told[2], told[1], told[3]


def folder_bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def measure(
    name: str, graph: MotionGraph, capture: Capture, load: Callable[..., Any], arguments: argparse.Namespace, site: Path
) -> list[Figure]:
    seconds = 4.0 if arguments.quick else 15.0
    frames = arguments.frames or (400 if arguments.quick else 10_000)
    export_site(graph, capture, load, site, options=SiteOptions(decimate=arguments.decimate))
    weight = folder_bytes(site)
    faces = int(np.median([len(capture.read(i).faces) for i in range(0, len(capture), max(len(capture) // 5, 1))]))
    counts = name.startswith(("10k", "work"))
    figures = [figure(f"{name}: faces a frame as captured", faces, "", None, None)]
    rate, cost = viewer_rate(graph, capture, load, seconds)
    due, due_cost = read_when_due_rate(graph, capture, load, min(seconds, 5.0))
    reach = RATE if counts and arguments.decimate is None else None
    figures += [
        figure(
            f"{name}: viewer, pictures a second", rate, "1/s", reach, None if reach is None else rate > 0.97 * reach
        ),
        figure(f"{name}: viewer, processor time a picture", cost, "ms", None, None),
        figure(f"{name}: peer, read when due, pictures a second", due, "1/s", None, None),
        figure(f"{name}: peer, read when due, processor time a picture", due_cost, "ms", None, None),
    ]
    server = site_server(site)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with browser() as tab:
        first, rate, cost, fine = page_rate(tab, f"http://127.0.0.1:{server.server_address[1]}/", seconds)
        early, late, early_heap, late_heap = page_memory(tab, frames)
        errors = len(tab.errors)
    server.shutdown()
    server.server_close()
    captured = sum(folder_bytes_of(capture, index) for index in range(len(capture)))
    minute = 60 * capture.fps / len(capture)
    reach = RATE if counts else None
    figures += [
        figure(f"{name}: page, first picture", first, "s", 2.0, first <= 2.0),
        rate_figure(f"{name}: page, pictures a second", rate, reach),
        figure(f"{name}: page, processor time a picture", cost, "ms", None, None),
        figure(f"{name}: page, drawn pixels a pixel", fine, "", None, None),
        figure(f"{name}: page, complaints of the browser", errors, "", 0, errors == 0),
        figure(f"{name}: page, script heap after {frames // 5} frames", early_heap, "MB", None, None),
        figure(f"{name}: page, script heap after {frames} frames", late_heap, "MB", None, late_heap < early_heap + 2),
        figure(f"{name}: page, browser after {frames // 5} frames", early, "MB", None, None),
        figure(f"{name}: page, browser after {frames} frames", late, "MB", None, late < 1.1 * early),
        figure(f"{name}: page, weight", weight / 1e6, "MB", 25.0 if arguments.work else None,
               weight <= 25e6 if arguments.work else None),
        figure(f"{name}: page, weight a minute of capture", weight / 1e6 * minute, "MB", None, None),
        figure(f"{name}: peer, captured files a minute", captured / 1e6 * minute, "MB", None, None),
    ]  # fmt: skip
    early, late = viewer_memory(graph, capture, load, frames)
    figures += [
        figure(f"{name}: viewer's ring, memory after {frames // 5} frames", early, "MB", None, None),
        figure(f"{name}: viewer's ring, memory after {frames} frames", late, "MB", None, late < 1.1 * early),
    ]
    return figures


def folder_bytes_of(capture: Capture, index: int) -> int:
    """Bytes of a captured frame's mesh and images."""
    path = capture.frames[index].path
    return path.stat().st_size + sum(texture.path.stat().st_size for texture in capture.read(index).textures)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="10,000 faces only, few frames, short runs")
    parser.add_argument("--work", type=Path, help="measure the work folder of a finished build")
    parser.add_argument("--decimate", type=int, help="of the page: at most so many faces a frame")
    parser.add_argument("--frames", type=int, help="frames over which memory is watched; 10,000 unless given")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    arguments = parser.parse_args()
    figures: list[Figure] = []
    with tempfile.TemporaryDirectory() as place:
        if arguments.work:
            work = open_work(arguments.work)
            figures += measure("work", work.graph, work.capture, work.load_transition, arguments, Path(place) / "site")
        for faces in () if arguments.work else (10_000,) if arguments.quick else (10_000, 50_000):
            folder = Path(place) / str(faces)
            write_procedural(folder, frames=20 if arguments.quick else 60, faces=faces, texture_size=1024)
            capture = open_capture(folder)
            name = f"{faces // 1000}k faces, 1 Mpixel"
            figures += measure(name, build_graph(capture, []), capture, no_transition, arguments, folder / "site")
    for entry in figures:
        print(
            f"{entry['name']}: {entry['value']:.4g} {entry['unit']} (reach {entry['reach']}, holds: {entry['holds']})"
        )
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
