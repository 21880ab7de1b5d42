"""Choices for the texture of synthesized frames."""

from dataclasses import dataclass

METHODS = ("flow", "crossfade")


@dataclass(frozen=True)
class TextureOptions:
    """How end textures are projected, moved and blended. JSON-ready.

    Attributes
    ----------
    method : "flow" moves both end textures along the optical flow while blending (P section 6.3) and gives
        back the fine detail that averaging loses; "crossfade" only blends
    texture_size : longest side of a transition's images in pixels at most; 0 keeps the captured size
    margin : pixels around charts that continue the surface across the seam, so that filtering shows no seam
    projection_reach : metres; captured surface farther away gives a texel no colour (holes are filled in). Half of what
        tracking may be off at most (P section 5.7: 10 cm)
    normal_agreement : least cosine between tracked and captured normals where colour is taken
    edge_length : flow is estimated on the template with edges split to this share of the bounding-box diagonal
        (P A.4, first step)
    levels : levels of the coarse-to-fine flow (P A.4: 7)
    signal_smoothing : weight of signal smoothing at the coarsest level, times the surface's area (P A.4: 3e-3)
    flow_smoothing : weight of flow smoothness at the coarsest level, for colours in 0..255 (P A.4: 1e6)
    tolerance : relative residual at which a level's linear system counts as solved
    noise : grey levels (0..255); differences below it are not held against the flow where it is judged
    quality : JPEG quality, 1..100, without chroma subsampling
    """

    method: str = "flow"
    texture_size: int = 0
    margin: int = 4
    projection_reach: float = 0.05
    normal_agreement: float = 0.3
    edge_length: float = 0.006
    levels: int = 7
    signal_smoothing: float = 3e-3
    flow_smoothing: float = 1e6
    tolerance: float = 1e-2
    noise: float = 8.0
    quality: int = 93

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f"method: expected one of {', '.join(METHODS)}, got {self.method!r}")
        for name, low, high in (
            ("texture_size", 0, 16384),
            ("margin", 0, 64),
            ("levels", 1, 20),
            ("quality", 1, 100),
        ):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
                raise ValueError(f"{name}: expected a whole number in {low}..{high}, got {value!r}")
        for name in ("projection_reach", "edge_length", "signal_smoothing", "flow_smoothing", "tolerance", "noise"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name}: expected a number above 0, got {getattr(self, name)!r}")
        if not 0 < self.normal_agreement < 1:
            raise ValueError(f"normal_agreement: expected a cosine between 0 and 1, got {self.normal_agreement!r}")
