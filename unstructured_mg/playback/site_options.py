"""Choices for a capture's web page."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SiteOptions:
    """What a page's files trade for size. JSON-ready.

    Attributes
    ----------
    texture_size : longest side of an image in pixels at most; 1024 x 1024 is what a page shows smoothly without a GPU
    quality : of the images, WebP, 1..100
    decimate : most faces a frame, as far as the texture's seams allow, or None: as captured
    precision : metres; positions are whole multiples of it (coarser where a frame is larger than 65,535 of them)
    """

    texture_size: int = 1024
    quality: int = 80
    decimate: int | None = None
    precision: float = 1e-4

    def __post_init__(self) -> None:
        for name, low, high in (("texture_size", 16, 8192), ("quality", 1, 100)):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
                raise ValueError(f"{name}: expected a whole number in {low}..{high}, got {value!r}")
        if self.decimate is not None and self.decimate < 4:
            raise ValueError(f"decimate: expected 4 faces or more, got {self.decimate!r}")
        if not 0 < self.precision < 1:
            raise ValueError(f"precision: expected metres above 0 and below 1, got {self.precision!r}")
