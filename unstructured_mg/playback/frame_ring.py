"""Frames read ahead of what is played, in threads, into a ring of a fixed size."""

import io
from collections import OrderedDict
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from threading import Lock

import numpy as np
from PIL import Image

from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.playback.site_mesh import draw_order
from unstructured_mg.playback.stream import LoadTransition, posed_frames
from unstructured_mg.playback.walk import WalkFrame
from unstructured_mg.synthesis.transition import Transition

Key = tuple[int, ...]

# Frames that are kept, frames that are read ahead, transitions that are kept, and threads that read.
KEPT, AHEAD, TRANSITIONS, THREADS = 24, 12, 2, 2


@dataclass(frozen=True)
class ReadyFrame:
    """A frame ready to be drawn, mesh and texture in one object, so that they cannot part.

    Attributes
    ----------
    vertices : (c, 3) float32, metres, z up, where the frame was captured: one a corner of the atlas
    faces : (m, 3) int64, those of one material together
    faces_of_material : how many each material has
    uv : (c, 2) float32, v upwards; empty without images
    images : (height, width, 3) uint8 a material
    colors : (c, 3) uint8, or None
    """

    key: Key
    vertices: np.ndarray
    faces: np.ndarray
    faces_of_material: tuple[int, ...]
    uv: np.ndarray
    images: tuple[np.ndarray, ...]
    colors: np.ndarray | None


def key_of(frame: WalkFrame) -> Key:
    """What a frame shows, wherever it stands."""
    if frame.frame is not None:
        return (frame.frame,)
    assert frame.transition is not None and frame.step is not None
    return (*frame.transition, frame.step)


class FrameRing:
    """Reads frames ahead and keeps the last few.

    Attributes
    ----------
    faults : why frames cannot be used, by key: a sentence each
    """

    def __init__(self, capture: Capture, load_transition: LoadTransition):
        self.faults: dict[Key, str] = {}
        self._capture, self._load = capture, load_transition
        self._transitions: OrderedDict[tuple[int, int], Transition] = OrderedDict()
        self._lock = Lock()
        self._threads = ThreadPoolExecutor(THREADS)
        self._frames: OrderedDict[Key, Future[ReadyFrame]] = OrderedDict()

    def want(self, coming: Sequence[WalkFrame]) -> None:
        """Start reading what comes next, and forget the oldest of what is not among it."""
        for frame in coming[:AHEAD]:
            key = key_of(frame)
            if key in self._frames:
                self._frames.move_to_end(key)
            elif key not in self.faults:
                self._frames[key] = self._threads.submit(self._read, frame)
        while len(self._frames) > KEPT:
            _, oldest = self._frames.popitem(last=False)
            oldest.cancel()

    def get(self, frame: WalkFrame, wait: bool = False) -> ReadyFrame | None:
        """A frame where it has been read, with ``wait`` as soon as it has; None where not, or where it has a fault."""
        key = key_of(frame)
        if key in self.faults:
            return None
        if key not in self._frames:
            self.want([frame])
        future = self._frames[key]
        if not wait and not future.done():
            return None
        try:
            return future.result()
        except (UserError, OSError, ValueError) as error:
            self.faults[key] = str(error)
            del self._frames[key]
            return None

    def close(self) -> None:
        self._threads.shutdown(cancel_futures=True)

    def _transition(self, source: int, target: int) -> Transition:
        with self._lock:
            if (source, target) not in self._transitions:
                self._transitions[source, target] = self._load(source, target)
            self._transitions.move_to_end((source, target))
            while len(self._transitions) > TRANSITIONS:
                self._transitions.popitem(last=False)
            return self._transitions[source, target]

    def _read(self, frame: WalkFrame) -> ReadyFrame:
        posed = next(posed_frames([frame], self._capture, self._transition))
        images = []
        for texture in posed.textures if len(posed.face_uv) else ():
            with Image.open(io.BytesIO(texture.data)) as opened:
                images.append(np.asarray(opened.convert("RGB")))
        face_uv = posed.face_uv if images else posed.face_uv[:0]
        drawing = draw_order(posed.faces, face_uv, posed.face_material, len(images))
        return ReadyFrame(
            key=key_of(frame),
            vertices=posed.own_vertices[drawing.vertex_of].astype(np.float32),
            faces=drawing.faces,
            faces_of_material=drawing.faces_of_material,
            uv=posed.uv[drawing.uv_of].astype(np.float32) if images else np.zeros((0, 2), np.float32),
            images=tuple(images),
            colors=None if posed.colors is None or images else posed.colors[drawing.vertex_of],
        )
