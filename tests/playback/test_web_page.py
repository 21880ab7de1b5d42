"""The page in a real browser, drawn in software."""

import shutil
import threading
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
import pytest
from chromium import browser, chromium_path
from signal_toy import STEP_WIDTH, WIDTHS, K, color, signal_capture, signal_links, signal_transition
from toy_capture import toy_capture

from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.request import PathRequest
from unstructured_mg.playback.conformance import frame_label
from unstructured_mg.playback.serve import site_server
from unstructured_mg.playback.site import export_site
from unstructured_mg.playback.walk import path_walk, random_walk

CAPTURE = signal_capture(60)
GRAPH = build_graph(CAPTURE, signal_links((10, 40), (20, 50)))
WALK = 10_000

# Looks straight at the sheets, in a small picture; between two pictures the camera has all the time that it wants.
PREPARE = """(() => {
  const { page } = umg;
  page.player.play(false);
  let time = 0;
  page.player.clock = () => (time += 10);
  Object.assign(document.getElementById("picture").style, { position: "fixed", width: "64px", height: "64px" });
  page.camera.azimuth = -Math.PI / 2;
  page.camera.elevation = 0;
})()"""
# What the pixels say: the sheet's colour at its middle, and its width over its height.
LOOK = """globalThis.look = () => {
  const { gl } = umg.page.picture, [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
  const pixels = globalThis.pixels ||= new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let left = w, right = -1, low = h, high = -1;
  for (let y = 0; y < h; y++) for (let x = 0; x < w; x++) if (pixels[4 * (y * w + x) + 2] > 243) {
    if (x < left) left = x; if (x > right) right = x; if (y < low) low = y; if (y > high) high = y;
  }
  const at = 4 * (((low + high) >> 1) * w + ((left + right) >> 1));
  return [pixels[at], pixels[at + 1], (right - left + 1) / (high - low + 1)];
}"""

SHOWN = """(async () => {
  const told = [];
  for (let i = 0; i < COUNT; i++) told.push((await umg.page.show(i))?.name ?? null);
  return told;
})()"""


@contextmanager
def serving(site):
    server = site_server(site)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}/"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page") / "site"
    export_site(GRAPH, CAPTURE, signal_transition, folder)
    return folder


@pytest.fixture(scope="module")
def tab():
    if chromium_path() is None:
        pytest.skip("chromium is not there: make tools")
    with browser() as opened:
        yield opened


@pytest.fixture
def page(tab, site):
    """The page, playing, its first picture drawn."""
    with serving(site) as address:
        tab.errors.clear()
        tab.size(900, 700)
        tab.open(address)
        tab.wait("globalThis.umg?.page?.drawn")
        yield tab
        assert tab.errors == []


def names(walk):
    return [frame_label(frame, CAPTURE) for frame in walk]


def expected_look(frame):
    """Red and green, and width over height, of a walk's frame."""
    if frame.transition is None:
        return *color(frame.frame)[:2], WIDTHS[frame.frame % 4] / 1.8
    source, target = frame.transition
    share = (frame.step + K) / (2 * K)
    ends = zip(color(source - K), color(target + K), strict=True)
    return *[(1 - share) * a + share * b for a, b in ends][:2], STEP_WIDTH / 1.8


def test_ten_thousand_frames_are_those_of_umg_walk_and_no_mesh_meets_another_frames_texture(page):
    """By what was put on the card, and by what the pixels of every fourth show: the mesh's shape, the texture's colour.

    The camera turns with the world, so that every sheet is seen in full.
    """
    walk = random_walk(GRAPH, CAPTURE, WALK, 1).frames
    page.evaluate(PREPARE)
    page.evaluate(LOOK)
    play = """(async () => {
      const told = [];
      for (let i = FROM; i < TO; i++) {
        umg.page.camera.azimuth = umg.page.player.reel.frame(i).world.yaw - Math.PI / 2;
        const drawn = await umg.page.show(i);
        told.push([drawn.name, drawn.mesh, drawn.texture, ...(i % 4 ? [] : look())]);
      }
      return told;
    })()"""
    heaps, told = [], []
    for first in range(0, WALK, 1000):
        told += page.evaluate(play.replace("FROM", str(first)).replace("TO", str(first + 1000)))
        page.command("HeapProfiler.collectGarbage")
        heaps.append(page.command("Runtime.getHeapUsage"))
    assert [each[0] for each in told] == names(walk)
    for name, mesh, texture, *_ in told:
        assert mesh == texture == name.split(":")[0]
    for frame, (name, _, _, red, green, shape) in zip(walk[::4], told[::4], strict=True):
        looked = expected_look(frame)
        assert abs(red - looked[0]) <= 6 and abs(green - looked[1]) <= 6 and abs(shape - looked[2]) < 0.06, name
    # Memory is flat: what lives after 2,000 frames lives after 10,000, and nothing else.
    assert heaps[-1]["usedSize"] < heaps[1]["usedSize"] + 300_000
    rings = page.evaluate("[umg.page.loader.ready.size, umg.page.loader.files.size, umg.page.picture.slots.f.length]")
    assert rings[0] <= 46 and rings[1] <= 64 and rings[2] == 2


def test_time_passes_and_the_page_plays(page):
    page.evaluate(
        "globalThis.time = 0; umg.page.player.clock = () => time; umg.page.player.put(umg.page.player.reel, 0)"
    )
    shown = []
    for hundredths in range(0, 100, 10):
        page.evaluate(f"globalThis.time = {hundredths / 100}")
        page.wait(f"umg.page.drawn.index === {int(hundredths * 0.3 + 1e-9)}")
        shown.append(page.evaluate("umg.page.drawn.name"))
    walk = names(random_walk(GRAPH, CAPTURE, 40, 1))
    assert shown == [walk[int(h * 0.3 + 1e-9)] for h in range(0, 100, 10)]


def test_a_click_on_the_timeline_walks_to_that_frame_by_the_shortest_way(page):
    page.evaluate("umg.page.player.play(false); umg.page.show(30)")
    page.wait("umg.page.drawn.index === 30")
    walked = random_walk(GRAPH, CAPTURE, 200, 1).frames
    turn = next(i for i in range(30, 200) if walked[i].frame is not None)
    goal = 15 if walked[turn].frame != 15 else 16
    page.evaluate("umg.page.player.clock = () => 0")
    place = page.evaluate(f"umg.page.timeline.screenX({goal})")
    page.click(place["x"], place["y"])
    assert page.evaluate("umg.page.goal.frame") == goal and page.evaluate("umg.page.player.playing")
    way = path_walk(GRAPH, CAPTURE, PathRequest(walked[turn].frame, goal)).frames
    expected = names([*walked[31 : turn + 1], *way[1:]])
    play = """(async () => {
      const told = [];
      for (let i = 31; i < 31 + COUNT; i++) told.push((await umg.page.show(i)).name);
      return told;
    })()"""
    assert page.evaluate(play.replace("COUNT", str(len(expected)))) == expected
    assert expected[-1] == CAPTURE.frame_id(goal) and page.evaluate("umg.page.goal") is None


def test_an_arc_shows_its_transition_and_its_seams_before_and_after(page):
    page.press("t")
    page.evaluate("document.getElementById('seam-start').click()")
    shown = []
    for _ in range(2):
        page.wait("umg.page.drawn.index === umg.page.player.index && umg.page.isDrawn(umg.page.last)")
        shown.append(page.evaluate("umg.page.drawn.name"))
        page.press("b")
    page.evaluate("document.getElementById('seam-end').click()")
    for _ in range(2):
        page.wait("umg.page.drawn.index === umg.page.player.index")
        shown.append(page.evaluate("umg.page.drawn.name"))
        page.press("b")
    link = page.evaluate("umg.page.graph.links[umg.page.selected]")
    source, target = (CAPTURE.frame_id(link[end]) for end in ("source", "target"))
    leaves, arrives = (CAPTURE.frame_id(link[end]) for end in ("leaves", "arrives"))
    assert shown == [leaves, f"{source}>{target}:{1 - K}", f"{source}>{target}:{K - 1}", arrives]
    page.press("Escape")
    assert page.evaluate("umg.page.mode") == "walk"


def test_keys_and_buttons_do_what_they_say(page):
    page.evaluate("document.getElementById('picture').focus()")
    page.press("c")
    assert page.evaluate("umg.page.mode") == "capture"
    page.press(" ")
    assert page.evaluate("umg.page.player.playing") is False
    before = page.evaluate("umg.page.player.index")
    page.press(".")
    assert page.evaluate("umg.page.player.index") == before + 1
    page.press("[")
    assert page.evaluate("umg.page.player.speed") == 0.5
    page.press("w")
    page.press("n")
    assert page.evaluate("[umg.page.seed, Number(document.getElementById('seed').value), umg.page.mode]") == [
        2,
        2,
        "walk",
    ]
    walk = names(random_walk(GRAPH, CAPTURE, 60, 2))
    assert page.evaluate("umg.page.player.reel.frame(59)") is not None
    assert page.evaluate("umg.page.nameOf(umg.page.player.reel.frame(59))") == walk[59]
    turned = page.evaluate("umg.page.camera.azimuth")
    page.press("ArrowLeft")
    assert page.evaluate("umg.page.camera.azimuth") == pytest.approx(turned + 0.1)
    page.press("?")
    assert page.evaluate("document.getElementById('keys').open") is True


def test_touch_turns_and_pinches(page):
    page.evaluate("document.getElementById('picture').setPointerCapture = () => {}")
    before = page.evaluate("[umg.page.camera.azimuth, umg.page.camera.zoom]")
    for kind, points in (("touchStart", [(300, 200)]), ("touchMove", [(360, 200)]), ("touchEnd", [])):
        page.command("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y} for x, y in points])
    turned = page.evaluate("[umg.page.camera.azimuth, umg.page.camera.zoom]")
    assert turned[0] < before[0] and turned[1] == before[1]
    pinch = [("touchStart", [(300, 200), (340, 200)]), ("touchMove", [(200, 200), (440, 200)]), ("touchEnd", [])]
    for kind, points in pinch:
        touches = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(points)]
        page.command("Input.dispatchTouchEvent", type=kind, touchPoints=touches)
    assert page.evaluate("umg.page.camera.zoom") < 0.5 * before[1]


def test_it_opens_from_a_disk_without_a_server(tab, site):
    tab.errors.clear()
    tab.open((site / "index.html").as_uri())
    tab.wait("globalThis.umg?.page?.drawn")
    walk = names(random_walk(GRAPH, CAPTURE, 150, 1))
    tab.evaluate("umg.page.player.play(false)")
    told = tab.evaluate(SHOWN.replace("COUNT", "150"))
    assert told == walk and any(">" in name for name in told)
    assert tab.errors == []


def test_missing_and_damaged_files_are_passed_over_and_named(tab, site, tmp_path):
    copy = tmp_path / "site"
    shutil.copytree(site, copy)
    walk = random_walk(GRAPH, CAPTURE, 60, 1).frames
    captured = [frame.frame for frame in walk if frame.frame is not None]
    missing, damaged = (CAPTURE.frame_id(captured[at]) for at in (2, 5))
    (copy / "frames" / f"{missing}.js").unlink()
    file = copy / "frames" / f"{damaged}.js"
    content = file.read_bytes()
    file.write_bytes(content[:150] + bytes([content[150] ^ 4]) + content[151:])
    with serving(copy) as address:
        tab.open(address)
        tab.wait("globalThis.umg?.page?.drawn")
        tab.evaluate("umg.page.player.play(false)")
        told = tab.evaluate(SHOWN.replace("COUNT", "12"))
        assert told == [None if name in (missing, damaged) else name for name in names(walk[:12])]
        said = tab.evaluate("document.getElementById('messages').textContent")
        for name in (missing, damaged):
            assert f"Frame {name} is missing or damaged (frames/{name}.js): it is skipped" in said
        # Played, they are passed over.
        tab.evaluate("globalThis.time = 0; umg.page.player.clock = () => time")
        tab.evaluate("umg.page.player.put(umg.page.player.reel, 1); umg.page.player.play(true)")
        tab.wait("umg.page.drawn.index === 1")
        tab.evaluate("globalThis.time = 1.01 / 30")
        tab.wait("umg.page.drawn.index === 3")
    tab.errors.clear()


def test_a_capture_without_transitions_plays_and_says_so(tab, tmp_path):
    capture = signal_capture(8)
    export_site(build_graph(capture, []), capture, signal_transition, tmp_path / "site")
    with serving(tmp_path / "site") as address:
        tab.errors.clear()
        tab.open(address)
        tab.wait("globalThis.umg?.page?.drawn")
        assert "no transitions" in tab.evaluate("document.getElementById('messages').textContent")
        assert tab.evaluate("[umg.page.mode, umg.page.player.loop, document.getElementById('walk').disabled]") == [
            "capture",
            True,
            True,
        ]
        told = tab.evaluate(SHOWN.replace("COUNT", "8"))
        assert told == [capture.frame_id(i) for i in range(8)]
        assert tab.errors == []


def test_a_browser_without_webgl_gets_a_sentence(tab, site):
    script = "HTMLCanvasElement.prototype.getContext = () => null"
    number = tab.command("Page.addScriptToEvaluateOnNewDocument", source=script)["identifier"]
    try:
        tab.open((site / "index.html").as_uri())
        tab.wait("document.body?.classList.contains('stuck')")
        assert "WebGL 2" in tab.evaluate("document.getElementById('sentence').innerText")
        assert tab.evaluate("getComputedStyle(document.querySelector('footer')).display") == "none"
    finally:
        tab.command("Page.removeScriptToEvaluateOnNewDocument", identifier=number)


def test_an_untextured_and_a_coloured_capture_are_drawn(tab, tmp_path):
    """Plain surfaces are shaded, colours are shown as they are."""
    for kind in ("plain", "coloured"):

        def mesh(index, kind=kind):
            one = replace(CAPTURE.read(index), textures=())
            return one if kind == "plain" else replace(one, colors=np.tile(np.uint8([200, 40, 255]), (4, 1)))

        capture = toy_capture(4, mesh_of=mesh)
        export_site(build_graph(capture, []), capture, signal_transition, tmp_path / kind)
        with serving(tmp_path / kind) as address:
            tab.errors.clear()
            tab.open(address)
            tab.wait("globalThis.umg?.page?.drawn")
            tab.evaluate(PREPARE)
            tab.evaluate(LOOK)
            if kind == "coloured":
                assert tab.evaluate("umg.page.show(1).then(() => look().slice(0, 2))") == [200, 40]
            else:
                middle = "umg.page.show(1).then(() => {look(); return [...pixels.slice(8320, 8323)]})"
                assert tab.evaluate(middle) == [199, 199, 199]  # 0.78, lit from the front
            assert tab.errors == []
