"""A toy that repeats its pose while it moves steadily over the floor; transitions between its repeats are exact.

Whatever walk is taken, the toy must then move as steadily: frame m of a walk from frame a is ``placed(a + m)``.
"""

import numpy as np
from toy_capture import ToyCapture, toy_capture

from unstructured_mg.capture.mesh import Texture, TexturedMesh
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.synthesis.transition import Transition

PERIOD, K = 12, 3
STEP = PlanarRigid(0.05, 0.03, -0.01)
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
UV = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]])
FACE_UV = np.array([[0, 1, 2], [4, 2, 3]], np.int32)


def power(count: int) -> PlanarRigid:
    motion = PlanarRigid()
    for _ in range(abs(count)):
        motion = motion.after(STEP if count > 0 else STEP.inverse())
    return motion


def placed(time: int) -> np.ndarray:
    shape = np.random.default_rng(time % PERIOD).normal(size=(4, 3))
    return power(time).apply(shape)


def moving_capture(*run_lengths: int, textures: tuple[Texture, ...] = (), unit: float = 1.0, up: str = "z",
                   floor: float = 0.0) -> ToyCapture:  # fmt: skip
    material = np.array([0, 1], np.int32) if len(textures) > 1 else None

    def mesh(index: int) -> TexturedMesh:
        return TexturedMesh(placed(index), FACES, UV, FACE_UV, None, textures, material)

    return toy_capture(*run_lengths, mesh_of=mesh, unit=unit, up=up, floor=floor)


def moving_links(*pairs: tuple[int, int]) -> list[Link]:
    """Both ways between frames that are a multiple of the period apart."""
    ways = [way for pair in pairs for way in (pair, pair[::-1])]
    return [Link(source, target, K, power(source - target), 0.0) for source, target in ways]


def load_transition(source: int, target: int) -> Transition:
    steps = range(-K + 1, K)
    return Transition(
        source=source,
        target=target,
        k=K,
        vertices=np.stack([placed(source + step) for step in steps]),
        faces=FACES,
        uv=UV,
        face_uv=FACE_UV,
        textures=tuple(f"{source}-{target}{step:+d}".encode() for step in steps),
        texture_suffix=".png",
        colors=None,
        alignment=power(source - target),
        card={},
    )
