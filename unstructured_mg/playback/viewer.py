"""The window of ``umg view``: draws what the director says, with PyVista."""

import os
import sys
import time
from typing import Any

import numpy as np
import pyvista
import vtk

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.graph.motion_graph import MotionGraph
from unstructured_mg.playback.camera import view_rotation
from unstructured_mg.playback.director import KEYS, Director
from unstructured_mg.playback.facing import facing
from unstructured_mg.playback.frame_axis import frame_axis
from unstructured_mg.playback.frame_ring import FrameRing, ReadyFrame, key_of
from unstructured_mg.playback.plot_timeline import cost_colors
from unstructured_mg.playback.stream import LoadTransition
from unstructured_mg.playback.walk import WalkFrame

# Shares of the window: where the timeline's ground line lies, how far it reaches, and how near a click must be.
GROUND, LEFT, RIGHT, HIGH, NEAR = 0.11, 0.03, 0.97, 0.075, 0.012
SCRUB = 0.025
# Seconds in which the camera makes up for two thirds of the figure's lead; metres at which it jumps after it.
LAG, JUMP = 0.35, 1.5
# OpenGL's names for drawing without a graphics card, where smooth edges cost five times the rest of a picture.
IN_SOFTWARE = ("llvmpipe", "softpipe", "swiftshader", "swrast")
INK = (0.11, 0.14, 0.19)


class Viewer:
    """One window. ``tick`` and ``press`` are what its timer and its keys call; tests call them too."""

    def __init__(
        self,
        graph: MotionGraph,
        capture: Capture,
        load_transition: LoadTransition,
        seed: int = 1,
        off_screen: bool = False,
        size: tuple[int, int] = (1280, 800),
    ):
        self.director = Director(graph, capture, seed)
        self.ring = FrameRing(capture, load_transition)
        title = f"umg view: {capture.folder.name}"
        # Typed loosely: PyVista declares most of what a window has as perhaps missing.
        self.plotter: Any = pyvista.Plotter(off_screen=off_screen, window_size=list(size), title=title)
        self.plotter.background_color = pyvista.Color("#e0e3e7")
        self.shown: tuple[int, ...] | None = None
        self._actors: list[Any] = []
        self._drawn: tuple[Any, ...] | None = None
        self._target: np.ndarray | None = None
        self._help = False
        self._timeline = _Timeline(graph, capture, self.plotter)
        self._text = self.plotter.add_text("", position="upper_left", font_size=9, font="courier", color=INK)
        self._floor()
        self._listen()
        first = self.ring.get(self.director.shown(), wait=True)
        if first is None:
            raise UserError(next(iter(self.ring.faults.values())))
        self._azimuth = facing(first.vertices.astype(np.float64), first.faces.astype(np.int32))
        self.tick(0.0, wait=True)
        self.look_home()

    def open(self) -> None:
        """Draw for the first time, into the window or off screen."""
        self.plotter.show(interactive=False, auto_close=False)
        # What draws is known only now.
        if any(name in self.plotter.render_window.ReportCapabilities().lower() for name in IN_SOFTWARE):
            self.plotter.disable_anti_aliasing()

    def tick(self, seconds: float, wait: bool = False) -> None:
        """Let time pass and draw what is shown then; a frame that is not read yet leaves the last one standing."""
        director = self.director
        frame = director.advance(seconds)
        for _ in range(len(director.capture)):
            ready = self.ring.get(frame, wait)
            if ready is not None or not self.ring.faults or key_of(frame) not in self.ring.faults:
                break
            director.message = f"Skipped with its texture: {self.ring.faults[key_of(frame)]}"
            if director.reel.frame(director.index + 1) is None:
                break
            director.position = float(director.index + 1)
            frame = director.shown()
        self.ring.want(director.coming(12))
        if ready is not None:
            self._show(frame, ready, seconds)
        self._tell()

    def press(self, key: str) -> None:
        """A key by its X11 name."""
        if self.director.press(key):
            self.tick(0.0)
        elif key in ("r", "R"):
            self.look_home()
        elif key in ("h", "H", "question"):
            self._help = not self._help
            self._tell()

    def click(self, x: float, y: float) -> bool:
        """A click at shares of the window from its lower left corner; False where it is not on the timeline."""
        if y < SCRUB * 2:
            self.director.scrub((x - LEFT) / (RIGHT - LEFT))
            self.tick(0.0, wait=True)
            return True
        found = self._timeline.at(x, y)
        if found is None:
            return False
        kind, index = found
        if kind == "frame":
            self.director.go_to(index)
        else:
            self.director.select(index)
        self.tick(0.0)
        return True

    def look_home(self) -> None:
        """The camera in front of the figure."""
        assert self._target is not None
        back = -view_rotation(self._azimuth, 0.18)[2]
        camera = self.plotter.camera
        camera.view_angle = 30.0
        camera.focal_point = self._target
        camera.position = self._target + 1.6 * self._size / np.tan(np.radians(15)) / 2 * back
        camera.up = (0.0, 0.0, 1.0)
        camera.SetWindowCenter(0.0, -0.2)  # the figure stands above the timeline

    def run(self) -> None:
        """Show the window until it is closed."""
        last = time.perf_counter()

        def on_timer(*_: object) -> None:
            nonlocal last
            now = time.perf_counter()
            passed, last = now - last, now
            self.tick(passed)
            self.plotter.render_window.Render()

        interactor = self.plotter.iren.interactor
        interactor.AddObserver("TimerEvent", on_timer)
        self.open()
        interactor.CreateRepeatingTimer(10)
        interactor.Start()
        self.close()

    def close(self) -> None:
        self.ring.close()
        self.plotter.close()

    def _show(self, frame: WalkFrame, ready: ReadyFrame, seconds: float) -> None:
        drawn = (ready.key, frame.world)
        if drawn != self._drawn:
            if self.shown != ready.key:
                self._draw(ready)
            for actor in self._actors:
                actor.user_matrix = frame.world.matrix()
            self._drawn = drawn
        low, high = ready.vertices.min(axis=0), ready.vertices.max(axis=0)
        self._follow(frame.world.apply(((low + high) / 2).astype(np.float64)), float((high - low).max()), seconds)
        self._timeline.mark(frame, self.director)

    def _draw(self, ready: ReadyFrame) -> None:
        """Mesh and texture of one frame, put into the picture together."""
        for actor in self._actors:
            self.plotter.remove_actor(actor, render=False)
        self._actors = []
        first = 0
        for material, count in enumerate(ready.faces_of_material):
            mesh = pyvista.PolyData.from_regular_faces(ready.vertices, ready.faces[first : first + count])
            first += count
            looks: dict[str, Any] = {"color": (0.78, 0.78, 0.78), "lighting": True}
            if ready.images:
                mesh.active_texture_coordinates = ready.uv
                looks = {"texture": pyvista.Texture(ready.images[material]), "lighting": False}
            elif ready.colors is not None:
                looks = {"scalars": ready.colors, "rgb": True, "lighting": False}
            self._actors.append(self.plotter.add_mesh(mesh, render=False, reset_camera=False, **looks))
        self.shown = ready.key

    def _follow(self, centre: np.ndarray, size: float, seconds: float) -> None:
        if self._target is None or np.hypot(*(centre - self._target)[:2]) > JUMP:
            move = centre - (centre if self._target is None else self._target)
            self._target, self._size = centre, size
        else:
            move = (1 - np.exp(-seconds / LAG)) * (centre - self._target)
            self._target = self._target + move
        camera = self.plotter.camera
        camera.position = np.asarray(camera.position) + move
        camera.focal_point = np.asarray(camera.focal_point) + move
        # The floor's lines go along in steps of a cell: it has no end.
        x, y = 0.5 * np.floor(self._target[:2] / 0.5)
        self._ground.position = (float(x), float(y), 0.0)
        self.plotter.renderer.ResetCameraClippingRange()

    def _tell(self) -> None:
        lines = [self.director.status()]
        if self.director.message:
            lines.append(self.director.message)
        if self._help:
            lines += ["", *(f"{key:14s} {what}" for key, what in KEYS)]
        else:
            lines.append("h: keys")
        self._text.set_text("upper_left", "\n".join(lines))

    def _floor(self) -> None:
        reach = np.arange(-20, 20.01, 0.5)
        ends = [[[x, -20, 0], [x, 20, 0]] for x in reach] + [[[-20, y, 0], [20, y, 0]] for y in reach]
        points = np.array(ends, np.float64).reshape(-1, 3)
        self._ground = self.plotter.add_mesh(
            pyvista.line_segments_from_points(points), color=(0.75, 0.77, 0.8), line_width=1, lighting=False,
            render=False, reset_camera=False,
        )  # fmt: skip

    def _listen(self) -> None:
        interactor = self.plotter.iren.interactor

        def on_key(caller: Any, _: str) -> None:
            key = caller.GetKeySym() or ""
            if key not in ("q", "Q"):
                self.press(key)

        def on_press(caller: Any, _: str) -> None:
            (x, y), (width, height) = caller.GetEventPosition(), self.plotter.window_size
            if self.click(x / width, y / height):
                caller.GetCommand(pressed).AbortFlagOn()  # not the beginning of a turn of the camera

        # VTK's own keys (wireframe, surface, ...) would get in the way of ours.
        def on_char(caller: Any, _: str) -> None:
            if caller.GetKeySym() not in ("q", "Q"):
                caller.GetCommand(typed).AbortFlagOn()

        interactor.AddObserver("KeyPressEvent", on_key, 10.0)
        typed = interactor.AddObserver("CharEvent", on_char, 10.0)
        pressed = interactor.AddObserver("LeftButtonPressEvent", on_press, 10.0)


class _Timeline:
    """The captured frames along the window's foot, transitions as arcs coloured by cost, and what is shown now."""

    def __init__(self, graph: MotionGraph, capture: Capture, plotter: Any):
        self._graph, self._capture = graph, capture
        self.x = frame_axis(capture, LEFT, RIGHT).x
        self._plotter = plotter
        colors = cost_colors([link.cost for link in graph.links])
        used = graph.links_used()
        self._arcs: dict[int, np.ndarray] = {}
        for run in capture.runs():
            plotter.add_actor(_line([(self.x[run.start], GROUND), (self.x[run.stop - 1], GROUND)], "#b9bec7", 6))
        inside = np.zeros(len(capture) + 2, bool)
        inside[1 + np.asarray(graph.frames)] = True
        edges = np.flatnonzero(np.diff(inside.astype(np.int8)))
        for first, stop in zip(edges[::2], edges[1::2], strict=True):
            plotter.add_actor(_line([(self.x[first], GROUND), (self.x[stop - 1], GROUND)], "#5b6577", 6))
        longest = max((abs(self.x[x.arrives] - self.x[x.leaves]) for x in graph.links), default=1.0)
        for index in sorted(used):
            link = graph.links[index]
            start, end = self.x[link.leaves], self.x[link.arrives]
            height = (0.25 + 0.75 * np.sqrt(abs(end - start) / longest)) * (HIGH if end > start else -0.6 * HIGH)
            turn = np.linspace(0, np.pi, 33)
            middle, half = (start + end) / 2, (start - end) / 2
            self._arcs[index] = np.stack([middle + half * np.cos(turn), GROUND + height * np.sin(turn)], axis=1)
            plotter.add_actor(_line(self._arcs[index], colors[index], 2))
        self._head = _line([(LEFT, GROUND - 0.02), (LEFT, GROUND + 0.02)], "#2b63c9", 3)
        plotter.add_actor(self._head)

    def at(self, x: float, y: float) -> tuple[str, int] | None:
        """("frame", index) or ("link", index) at shares of the window, or None beside them."""
        if abs(y - GROUND) < NEAR and LEFT - NEAR < x < RIGHT + NEAR:
            return "frame", int(np.abs(self.x - x).argmin())
        width, height = self._plotter.window_size
        away = {
            i: float(np.hypot(arc[:, 0] - x, (arc[:, 1] - y) * height / width).min()) for i, arc in self._arcs.items()
        }
        nearest = min(away, key=lambda index: away[index], default=None)
        return ("link", nearest) if nearest is not None and away[nearest] < NEAR else None

    def mark(self, frame: WalkFrame, director: Director) -> None:
        """Move the mark to what is shown."""
        if frame.frame is not None:
            x = self.x[frame.frame]
        else:
            assert frame.step is not None
            link = next(x for x in self._graph.links if (x.source, x.target) == frame.transition)
            share = (frame.step + link.k) / (2 * link.k)
            x = (1 - share) * self.x[link.leaves] + share * self.x[link.arrives]
        self._head.SetPosition(float(x) - LEFT, 0.0)
        self._head.GetProperty().SetColor(pyvista.Color("#2b63c9" if frame.step is None else "#c2660f").float_rgb)


def _line(points: Any, color: str, width: float) -> Any:
    """A line in shares of the window."""
    mapper, place = vtk.vtkPolyDataMapper2D(), vtk.vtkCoordinate()
    place.SetCoordinateSystemToNormalizedViewport()
    mapper.SetTransformCoordinate(place)
    mapper.SetInputData(pyvista.lines_from_points(np.array([(x, y, 0.0) for x, y in points])))
    actor = vtk.vtkActor2D()
    actor.SetMapper(mapper)
    actor.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    actor.GetProperty().SetColor(pyvista.Color(color).float_rgb)
    actor.GetProperty().SetLineWidth(width)
    return actor


def require_display() -> None:
    """UserError where there is no screen to open a window on."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise UserError(
            "there is no display to open a window on; write a web page instead: umg web WORK -o SITE --serve."
        )
