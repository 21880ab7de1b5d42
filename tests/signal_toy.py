"""A capture whose every frame can be told from a picture: its colour from its texture, its shape from its mesh.

Each frame is an upright sheet, 1.8 m high, of one colour. Frame i is WIDTHS[i % 4] wide and coloured ``color(i)``; the
steps of a transition have a width of their own and go from one frame's colour to the other's.
"""

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image
from toy_capture import ToyCapture, toy_capture

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.synthesis.texture_flow import TextureFlow
from unstructured_mg.synthesis.transition import Transition

K = 3
WIDTHS = (0.5, 0.8, 1.1, 1.4)
STEP_WIDTH = 1.7
HEIGHT = 1.8
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
UV = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
MOTION = PlanarRigid(0.4, 0.3, -0.2)


@dataclass(frozen=True)
class PlainTexture:
    """A texture of one colour that needs no file."""

    color: tuple[int, int, int]

    def pixels(self) -> np.ndarray:
        return np.full((16, 16, 3), self.color, np.uint8)


def color(frame: int) -> tuple[int, int, int]:
    """Steps of 32 levels, and far from the page's grey backdrop."""
    return 32 * (frame % 8), 32 * (frame // 8), 255


def sheet(width: float) -> np.ndarray:
    """Facing -y: what a camera at azimuth -90 degrees sees in full."""
    return np.array([[-width / 2, 0, 0], [width / 2, 0, 0], [width / 2, 0, HEIGHT], [-width / 2, 0, HEIGHT]])


def signal_capture(*run_lengths: int) -> ToyCapture:
    def mesh(index: int) -> TexturedMesh:
        return TexturedMesh(sheet(WIDTHS[index % 4]), FACES, UV, FACES, None, (PlainTexture(color(index)),))  # type: ignore[arg-type]

    return toy_capture(*run_lengths, mesh_of=mesh)


def signal_links(*pairs: tuple[int, int]) -> list[Link]:
    """Both ways between two frames; costs differ."""
    ways = [(s, t, motion) for a, b in pairs for s, t, motion in ((a, b, MOTION), (b, a, MOTION.inverse()))]
    return [Link(s, t, K, motion, 0.1 * number) for number, (s, t, motion) in enumerate(ways)]


def signal_transition(source: int, target: int) -> Transition:
    steps = 2 * K - 1
    ends = tuple(encoded(color(frame)) for frame in (source - K, target + K))
    flow = TextureFlow(
        sheet(STEP_WIDTH).astype(np.float32), np.zeros((4, 3), np.float32), np.zeros((4, 2), np.float32), ends, ".png",
        None,
    )  # fmt: skip
    poses = np.stack([sheet(STEP_WIDTH)] * steps)
    alignment = MOTION if source < target else MOTION.inverse()
    return Transition(source, target, K, poses, FACES, UV, FACES, (ends[0],) * steps, ".png", None, alignment, {}, flow)


def encoded(shade: tuple[int, int, int]) -> bytes:
    data = io.BytesIO()
    Image.fromarray(PlainTexture(shade).pixels()).save(data, "PNG")
    return data.getvalue()
