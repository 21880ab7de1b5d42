"""What a viewer plays, and what its keys and clicks do to it. Knows no window: a viewer asks it what to show."""

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.graph.motion_graph import MotionGraph
from unstructured_mg.graph.paths import require_frame
from unstructured_mg.playback.random_generator import MASK
from unstructured_mg.playback.reels import FixedReel, WalkReel, transition_reel
from unstructured_mg.playback.walk import WalkFrame, capture_walk, default_start

SPEEDS = (0.1, 0.25, 0.5, 1.0, 1.5, 2.0)
# Captured frames that are shown on each side of a transition.
CONTEXT = 15
# Seconds of a stalled window that count at most.
STALL = 0.25

KEYS = (
    ("Space", "play or pause"),
    (", .", "one frame back, one frame on"),
    ("w c", "endless walk, or the capture as it is"),
    ("l", "loop: a walk goes back to where it is by the shortest way, over and over"),
    ("[ ]", "slower, faster"),
    ("n", "another walk: the next seed"),
    ("t", "look at the next transition"),
    ("b", "its seams: before or after"),
    ("Escape", "back to the walk"),
    ("r", "turn the camera back"),
    ("h", "these keys"),
    ("q", "close"),
    ("Drag, wheel", "turn; closer or farther"),
    ("Timeline", "click a frame: walk there; click an arc: look at that transition; click below: scrub"),
)


class Director:
    """Plays a graph by elapsed time.

    Attributes
    ----------
    mode : "walk", "capture" or "transition"
    position : in frames of the reel that is played
    playing, loop, speed, seed : as shown
    link : the transition that is looked at, or None
    message : a sentence for the user, or None
    """

    def __init__(self, graph: MotionGraph, capture: Capture, seed: int = 1):
        self.graph, self.capture = graph, capture
        self.links = tuple(sorted(graph.links_used()))
        self.seed, self.speed = seed, 1.0
        self.playing, self.loop = True, False
        self.message: str | None = None
        self.link: int | None = None
        self.goal: tuple[int, int] | None = None
        self.position, self._furthest = 0.0, 0
        self._seams = (0, 0)
        if self.links:
            self.walk()
        else:
            self.show_capture()
            self.message = "This build has no transitions that join up: the capture plays as it was captured."

    @property
    def index(self) -> int:
        return int(self.position)

    def shown(self) -> WalkFrame:
        """The frame to be shown now."""
        found = self.reel.frame(self.index)
        assert found is not None
        return found

    def coming(self, count: int) -> list[WalkFrame]:
        """The frames from now on, as far as they are known to follow."""
        found = (self.reel.frame(self.index + ahead) for ahead in range(count))
        return [frame for frame in found if frame is not None]

    def advance(self, seconds: float) -> WalkFrame:
        """Let time pass; the frame to be shown then."""
        if self.playing:
            self.position += min(max(seconds, 0.0), STALL) * self.capture.fps * self.speed
            if self.reel.frame(self.index) is None:
                first, count = self.reel.first, self.reel.known - self.reel.first
                if self.loop or self.mode == "transition" or not self.links:
                    self.position = first + (self.position - first) % count
                else:
                    self.position, self.playing = self.reel.known - 1, False
        if self.goal is not None and self.index >= self.goal[1]:
            self.goal = None
        return self.shown()

    # What keys and clicks do.

    def walk(self, start: int | None = None) -> None:
        """An endless walk with the seed, from ``start`` where that is in the graph."""
        begin = default_start(self.graph, self.capture) if start is None or start not in self.graph.frames else start
        self._begin("walk", WalkReel(self.graph, self.capture, self.seed, begin))

    def show_capture(self, frame: int = 0) -> None:
        """The capture as it is, from captured frame ``frame``."""
        self._begin("capture", FixedReel(capture_walk(self.capture).frames))
        self.position = float(frame)

    def select(self, link: int) -> None:
        """Look at a transition, over and over."""
        reel, self._seams = transition_reel(self.graph, self.capture, link, CONTEXT)
        self._begin("transition", reel)
        self.link, self.playing = link, True

    def next_link(self) -> None:
        if self.links:
            at = -1 if self.link is None else self.links.index(self.link)
            self.select(self.links[(at + 1) % len(self.links)])

    def flip_seam(self) -> None:
        """Stand still before the first seam of the transition, after it, before the second one, after it, and so on."""
        if self.mode == "transition":
            sides = [seam + side for seam in self._seams for side in (0, 1)]
            at = sides.index(self.index) if self.index in sides and not self.playing else -1
            self.playing = False
            self.position = float(sides[(at + 1) % len(sides)])

    def go_to(self, frame: int) -> None:
        """A captured frame was chosen: walk there the shortest way; of the plain capture, show it."""
        if self.mode == "capture":
            self.position = float(frame)
            return
        if self.mode == "transition":
            self.walk(self._walkable())
        assert isinstance(self.reel, WalkReel)
        try:
            require_frame(self.graph, frame, self.capture)
            self.goal = frame, self.reel.go_to(self.index, frame)
            self.loop, self.playing = False, True
        except UserError as error:
            self.message = str(error)

    def toggle_loop(self) -> None:
        self.loop = not self.loop
        if isinstance(self.reel, WalkReel):
            self.goal = None
            if not self.loop:
                self.reel.wander_from(self.index)
                return
            try:
                self.reel.loop_from(self.index)
            except UserError as error:
                self.loop, self.message = False, str(error)

    def toggle_play(self) -> None:
        if not self.playing and self.reel.ended and self.index >= self.reel.known - 1:
            self.position = float(self.reel.first)
        self.playing = not self.playing

    def step(self, by: int) -> None:
        self.playing = False
        if self.reel.frame(self.index + by) is not None:
            self.position = float(self.index + by)

    def scrub(self, share: float) -> None:
        """Stand still at a share, 0 to 1, of what is known of the reel (of a walk: what was shown)."""
        self.playing = False
        last = max(self._furthest, self.index) if self.mode == "walk" else self.reel.known - 1
        self._furthest = last
        self.position = float(round(self.reel.first + min(max(share, 0.0), 1.0) * (last - self.reel.first)))

    def faster(self, by: int) -> None:
        at = SPEEDS.index(self.speed) + by
        self.speed = SPEEDS[min(max(at, 0), len(SPEEDS) - 1)]

    def next_seed(self) -> None:
        self.seed = (self.seed + 1) & MASK
        if self.links:
            self.walk()
            self.playing = True

    def back_to_walk(self) -> None:
        if self.links and self.mode != "walk":
            self.walk(self._walkable())

    def press(self, key: str) -> bool:
        """Do what a key does, by its X11 name; False where it does nothing here."""
        acts = {
            "space": self.toggle_play,
            "comma": lambda: self.step(-1),
            "period": lambda: self.step(1),
            "w": self.back_to_walk,
            "c": lambda: None if self.mode == "capture" else self.show_capture(self.shown().frame or 0),
            "l": self.toggle_loop,
            "bracketleft": lambda: self.faster(-1),
            "bracketright": lambda: self.faster(1),
            "n": self.next_seed,
            "t": self.next_link,
            "b": self.flip_seam,
            "Escape": lambda: self.back_to_walk() if self.mode == "transition" else None,
        }
        act = acts.get(key if len(key) > 1 else key.lower())
        if act is not None:
            act()
        return act is not None

    def status(self) -> str:
        """What is shown, in two lines: the reel's frame and time, and where the frame comes from."""
        name, frame, index = self.capture.frame_id, self.shown(), self.index
        self._furthest = max(self._furthest, index)
        of = "" if self.mode == "walk" else f" of {self.reel.known}"
        what = {"walk": f"Walk with seed {self.seed}", "capture": "Capture", "transition": "Transition"}[self.mode]
        seconds = index / self.capture.fps
        state = "" if self.playing else ", paused"
        state += ", loop" if self.loop else ""
        state += "" if self.speed == 1 else f", speed {self.speed:g}"
        first = f"{what}: frame {index + 1}{of}, {int(seconds // 60)}:{seconds % 60:04.1f}{state}"
        if frame.frame is not None:
            return f"{first}\ncaptured frame {name(frame.frame)} ({frame.frame + 1} of {len(self.capture)})"
        assert frame.transition is not None
        link = next(link for link in self.graph.links if (link.source, link.target) == frame.transition)
        return f"{first}\nsynthesized: {name(link.leaves)} to {name(link.arrives)}, step {frame.step}"

    def _begin(self, mode: str, reel: WalkReel | FixedReel) -> None:
        self.mode, self.reel, self.position = mode, reel, 0.0
        self.link, self.goal, self._furthest = None, None, 0
        if mode == "walk" and self.loop:
            self.loop = False
            self.toggle_loop()

    def _walkable(self) -> int | None:
        """The captured frame to walk on from: the one that is shown, or that the shown transition leads to."""
        frame = self.shown()
        if frame.frame is not None:
            return frame.frame
        return next(x.arrives for x in self.graph.links if (x.source, x.target) == frame.transition)
