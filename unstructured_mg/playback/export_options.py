"""What an export can be told, whatever its format."""

from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any

from unstructured_mg.capture.placement import UP_AXES

CAMERAS = ("fixed", "orbit")


@dataclass(frozen=True)
class ExportOptions:
    """Options of an export. Each can be said in JSON; what a format has no use for is refused, not ignored.

    Attributes
    ----------
    format : name of a format of ``playback.export.FORMATS``
    fps : frames a second of the export; the capture's own where None. The motion keeps its speed: of the walk's frames
        those nearest in time are shown, so that some are left out or shown twice
    first_number : the number in the first frame's file name, or its time code
    bounce : there and back again, so that the end joins the beginning: the first and the last frame are turning points
    hold : frames for which the last frame stays, and with ``bounce`` the first one too, beyond its own
    up : up axis of the export, as in Capture; the capture's own where None
    unit : metres a unit of the export; the capture's own where None
    decimate : most faces a frame, as far as the texture's seams allow, or None: as captured
    texture_size : most pixels along the longer side of a texture, or None: the original files, byte for byte
    camera : of a video: "fixed" sees the whole walk, "orbit" follows the figure and goes around it
    picture_height : of a video, pixels
    """

    format: str = "obj"
    fps: float | None = None
    first_number: int = 1
    bounce: bool = False
    hold: int = 0
    up: str | None = None
    unit: float | None = None
    decimate: int | None = None
    texture_size: int | None = None
    camera: str = "fixed"
    picture_height: int = 720

    def __post_init__(self) -> None:
        if self.fps is not None and not (isfinite(self.fps) and 0 < self.fps <= 1000):
            raise ValueError(f"fps: expected frames a second above 0 and at most 1000, got {self.fps!r}")
        if self.first_number < 0:
            raise ValueError(f"first_number: expected 0 or more, got {self.first_number!r}")
        if self.hold < 0:
            raise ValueError(f"hold: expected 0 or more frames, got {self.hold!r}")
        if self.up is not None and self.up not in UP_AXES:
            raise ValueError(f"up: expected one of {', '.join(UP_AXES)}, got {self.up!r}")
        if self.unit is not None and not 0 < self.unit < float("inf"):
            raise ValueError(f"unit: expected a positive number of metres, got {self.unit!r}")
        if self.decimate is not None and self.decimate < 4:
            raise ValueError(f"decimate: expected 4 faces or more, got {self.decimate!r}")
        if self.texture_size is not None and self.texture_size < 1:
            raise ValueError(f"texture_size: expected 1 pixel or more, got {self.texture_size!r}")

        if self.camera not in CAMERAS:
            raise ValueError(f"camera: expected one of {', '.join(CAMERAS)}, got {self.camera!r}")
        if not 16 <= self.picture_height <= 4320:
            raise ValueError(f"picture_height: expected 16 to 4320 pixels, got {self.picture_height!r}")

    def given(self) -> dict[str, Any]:
        """The options that differ from their defaults, JSON-ready."""
        default = asdict(ExportOptions())
        return {name: value for name, value in asdict(self).items() if value != default[name]}
