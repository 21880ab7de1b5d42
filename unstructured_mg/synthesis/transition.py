"""What synthesis hands to the graph and to playback."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.texture_flow import TextureFlow


@dataclass(frozen=True)
class Transition:
    """Synthesized frames between captured frames ``source - k`` and ``target + k``.

    A path plays ..., source - k, then steps -k+1 .. k-1, then target + k, ...: steps -k and k equal captured frames and
    are not stored. Vertices are in the source frame's captured place; ``alignment`` takes the target's captured place
    to it, so the walk's world transform is multiplied by it once, where the transition ends.

    Attributes
    ----------
    source, target : frame indices s and t
    k : half window
    vertices : (2k-1, n, 3) float64, metres, z up
    faces : (m, 3) int32
    uv : (q, 2) float64 and face_uv : (m, 3) int32, the transition's own single atlas (empty without texture)
    textures : 2k-1 encoded images, or empty
    texture_suffix : ".jpg" or ".png"
    colors : (2k-1, n, 3) uint8, or None
    alignment : target's place to source's place
    card : the quality card, JSON-ready
    flow : both end textures and the flow between them, for players that warp; None without any colour
    ends : the frames that it leaves and arrives at; None where these are ``source - k`` and ``target + k``
    """

    source: int
    target: int
    k: int
    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    face_uv: np.ndarray
    textures: tuple[bytes, ...]
    texture_suffix: str
    colors: np.ndarray | None
    alignment: PlanarRigid
    card: dict[str, Any]
    flow: TextureFlow | None = None
    ends: tuple[int, int] | None = None

    @property
    def leaves(self) -> int:
        """The captured frame that is shown before it."""
        return self.source - self.k if self.ends is None else self.ends[0]

    @property
    def arrives(self) -> int:
        """The captured frame that is shown after it."""
        return self.target + self.k if self.ends is None else self.ends[1]
