"""A walk as a stream of frames in their place in the world, one in memory at a time."""

from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.playback.walk import WalkFrame
from unstructured_mg.synthesis.transition import Transition

LoadTransition = Callable[[int, int], Transition]


@dataclass(frozen=True)
class EncodedImage:
    """A texture as it is stored.

    Attributes
    ----------
    data : the file's bytes; those of a captured texture are the original's
    suffix : the file's ending, ".jpg", ".png", ...
    """

    data: bytes
    suffix: str


@dataclass(frozen=True)
class PosedFrame:
    """One frame of a walk, ready to be shown.

    Attributes
    ----------
    own_vertices : (n, 3) float64, metres, z up, where the frame was captured (of a transition: its source was)
    faces, uv, face_uv, face_material, colors : as in TexturedMesh
    textures : one a material; empty where there is none
    origin : the walk's frame that this is
    """

    own_vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    face_uv: np.ndarray
    face_material: np.ndarray | None
    colors: np.ndarray | None
    textures: tuple[EncodedImage, ...]
    origin: WalkFrame

    @property
    def vertices(self) -> np.ndarray:
        """(n, 3) float64, world, metres, z up."""
        return self.origin.world.apply(self.own_vertices)


def posed_frames(
    walk: Iterable[WalkFrame], capture: Capture, load_transition: LoadTransition | None, transitions_kept: int = 2
) -> Iterator[PosedFrame]:
    """Read and place each of the walk's frames in turn.

    Parameters
    ----------
    walk : a Walk, or what ``endless_walk`` yields
    load_transition : gives the transition for (source, target) frame indices; called once for each time that one is
        played, or less often where it is among the ``transitions_kept`` last ones, which stay in memory; None where
        the walk shows captured frames only
    """
    recent: OrderedDict[tuple[int, int], Transition] = OrderedDict()
    for origin in walk:
        if origin.transition is None:
            yield _captured(origin, capture)
            continue
        if origin.transition not in recent:
            while len(recent) >= max(transitions_kept, 1):
                recent.popitem(last=False)
            assert load_transition is not None
            recent[origin.transition] = load_transition(*origin.transition)
        recent.move_to_end(origin.transition)
        yield _synthesized(origin, recent[origin.transition])


def _captured(origin: WalkFrame, capture: Capture) -> PosedFrame:
    assert origin.frame is not None
    mesh = capture.read(origin.frame)
    textures = tuple(EncodedImage(texture.read_bytes(), texture.suffix) for texture in mesh.textures)
    return PosedFrame(
        own_vertices=mesh.vertices,
        faces=mesh.faces,
        uv=mesh.uv,
        face_uv=mesh.face_uv,
        face_material=mesh.face_material,
        colors=mesh.colors,
        textures=textures,
        origin=origin,
    )


def _synthesized(origin: WalkFrame, transition: Transition) -> PosedFrame:
    assert origin.step is not None
    index = origin.step + transition.k - 1
    textures = (EncodedImage(transition.textures[index], transition.texture_suffix),) if transition.textures else ()
    return PosedFrame(
        own_vertices=transition.vertices[index],
        faces=transition.faces,
        uv=transition.uv,
        face_uv=transition.face_uv,
        face_material=None,
        colors=None if transition.colors is None else transition.colors[index],
        textures=textures,
        origin=origin,
    )
