"""The viewer's window, off screen."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from signal_toy import color, signal_capture, signal_links, signal_transition
from viewer_toy import on_disk

from unstructured_mg.errors import UserError
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.playback.viewer import Viewer, require_display
from unstructured_mg.playback.walk import random_walk

SIZE = (320, 240)
UPPER_LEFT = 2  # VTK's number of the corner


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    capture = on_disk(signal_capture(60), tmp_path_factory.mktemp("textures"))
    return build_graph(capture, signal_links((10, 40), (20, 50))), capture


@pytest.fixture
def viewer(toy):
    made = Viewer(*toy, signal_transition, seed=1, off_screen=True, size=SIZE)
    made.open()
    yield made
    made.close()


def picture(viewer):
    viewer.plotter.render_window.Render()
    return viewer.plotter.screenshot(return_img=True).astype(int)


def seen_color(viewer):
    """Red and green of the sheet, which alone is fully blue."""
    pixels = picture(viewer)
    sheet = pixels[(pixels[..., 2] > 250) & (np.abs(pixels[..., :2] - 225).max(axis=-1) > 25)]
    assert len(sheet) > 200
    return np.median(sheet[:, :2], axis=0)


def test_what_is_drawn_is_what_is_told_mesh_and_texture_of_one_frame(viewer, toy):
    walk = random_walk(*toy, 60, 1).frames
    for index in (0, 1, 5, 13, 29, 44, 59):
        viewer.director.position = float(index)
        viewer.director.playing = False
        viewer.tick(0.0, wait=True)
        frame = walk[index]
        if frame.frame is not None:
            assert viewer.shown == (frame.frame,)
            np.testing.assert_allclose(seen_color(viewer), color(frame.frame)[:2], atol=3)
        else:
            assert viewer.shown == (*frame.transition, frame.step)
        mesh = viewer._actors[0].mapper.dataset
        assert np.ptp(np.asarray(mesh.points)[:, 0]) == pytest.approx(
            1.7 if frame.frame is None else (0.5, 0.8, 1.1, 1.4)[frame.frame % 4], abs=1e-5
        )
        np.testing.assert_allclose(np.asarray(viewer._actors[0].user_matrix), frame.world.matrix(), atol=1e-12)


def test_clicks_on_the_timeline_are_real_mouse_events(viewer, toy):
    interactor = viewer.plotter.iren.interactor
    goal, timeline = 15, viewer._timeline

    def press(x, y):
        interactor.SetEventInformation(round(x * SIZE[0]), round(y * SIZE[1]), 0, 0)
        interactor.LeftButtonPressEvent()
        interactor.LeftButtonReleaseEvent()

    press(timeline.x[goal], 0.11)
    assert abs(viewer.director.goal[0] - goal) <= 1  # a frame is five pixels wide
    link = next(iter(timeline._arcs))
    press(*timeline._arcs[link][16])
    assert viewer.director.mode == "transition" and viewer.director.link in timeline._arcs
    before = viewer.director.link
    press(0.5, 0.7)
    assert viewer.director.link == before
    assert timeline.at(0.5, 0.7) is None


def test_keys_are_real_key_events(viewer):
    interactor = viewer.plotter.iren.interactor

    def press(key, sym):
        interactor.SetKeyEventInformation(0, 0, key, 1, sym)
        interactor.KeyPressEvent()
        interactor.CharEvent()

    press("t", "t")
    press("b", "b")
    assert viewer.director.mode == "transition" and not viewer.director.playing
    press("w", "w")
    assert viewer.director.mode == "walk"
    # VTK's "w" would have drawn wires.
    assert all(actor.prop.style == "Surface" for actor in viewer._actors)
    press("h", "h")
    assert "another walk" in viewer._text.GetText(UPPER_LEFT)
    eye = np.array(viewer.plotter.camera.position)
    viewer.plotter.camera.Azimuth(40)
    assert np.linalg.norm(np.array(viewer.plotter.camera.position) - eye) > 0.5
    press("r", "r")
    np.testing.assert_allclose(viewer.plotter.camera.position, eye, atol=1e-6)


def test_the_camera_follows_the_walk(viewer):
    start = np.array(viewer.plotter.camera.position) - viewer._target
    for index in range(0, 400, 4):
        viewer.director.position = float(index)
        viewer.tick(0.0, wait=True)
    for _ in range(100):
        viewer._follow(viewer._target + [0.02, 0, 0], viewer._size, 1 / 30)
    np.testing.assert_allclose(np.array(viewer.plotter.camera.position) - viewer._target, start, atol=1e-9)


def test_a_bad_frame_is_skipped_and_named(toy):
    graph, capture = toy
    bad = int(random_walk(*toy, 4, 1).frames[2].frame)

    def mesh(index):
        if index == bad:
            raise UserError(f"frame file {index} is damaged")
        return capture.mesh_of(index)

    viewer = Viewer(graph, replace(capture, mesh_of=mesh), signal_transition, off_screen=True, size=SIZE)
    viewer.director.position, viewer.director.playing = 2.0, False
    viewer.tick(0.0, wait=True)
    assert viewer.shown == (bad + 1,) and f"frame file {bad} is damaged" in viewer.director.message
    assert f"frame file {bad} is damaged" in viewer._text.GetText(UPPER_LEFT)
    viewer.close()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems always have a display")
def test_without_a_display_there_is_a_sentence(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(UserError, match="umg web"):
        require_display()
    monkeypatch.setenv("DISPLAY", ":0")
    require_display()
