"""One texture of a captured frame, wherever its pixels are."""

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from unstructured_mg.capture.basis import check_basis, read_basis
from unstructured_mg.capture.image import check_image, image_size, read_image
from unstructured_mg.capture.stretch import file_stamp, read_stretch
from unstructured_mg.capture.video import video_picture


@dataclass(frozen=True)
class Texture:
    """A texture image on disk, decoded only where pixels are needed.

    Attributes
    ----------
    path : the file that it is, or is in
    start, size : its bytes in that file; all from ``start`` on where ``size`` is None
    coding : "image" (PNG, JPEG, ...), "basis" (KTX2 or .basis) or "video"
    layer : which layer of a "basis" array, or picture of a "video", from 0
    ending : the ending that its name would have, where that is not the file's
    """

    path: Path
    start: int = 0
    size: int | None = None
    coding: str = "image"
    layer: int = 0
    ending: str = ""

    @property
    def suffix(self) -> str:
        """The ending of a file that holds what ``read_bytes`` gives."""
        return {"basis": ".png", "video": ".jpg"}.get(self.coding) or self.ending or self.path.suffix

    def pixels(self) -> np.ndarray:
        """Decode to ``(height, width, 3) uint8``, sRGB, top row first; grey, alpha, 16-bit and CMYK converted.

        Raises UserError as read_image, read_basis and video_picture.
        """
        if self.coding == "basis":
            return read_basis(self.path, self.start, self._data(), self.layer)
        if self.coding == "video":
            return read_image(video_picture(self.path, self.layer))
        return read_image(self.path, None if self._is_file() else self._data())

    def read_bytes(self) -> bytes:
        """The image as a file of its own: its original bytes where it is PNG, JPEG or the like, for exports that must
        not touch it; else a PNG of the decoded layer, or the JPEG that the video's picture was unpacked to.
        """
        if self.coding == "basis":
            file = io.BytesIO()
            Image.fromarray(self.pixels()).save(file, "PNG", compress_level=1)
            return file.getvalue()
        if self.coding == "video":
            return video_picture(self.path, self.layer).read_bytes()
        return self.path.read_bytes() if self._is_file() else self._data()

    def dimensions(self) -> tuple[int, int]:
        """``(width, height)``, by the header alone. Raises UserError as ``pixels``, but damaged pixels go unnoticed."""
        if self.coding == "basis":
            return check_basis(self.path, self.start, self._data())[:2]
        if self.coding == "video":
            return image_size(video_picture(self.path, self.layer))
        return image_size(self.path, None if self._is_file() else self._data())

    def check(self) -> None:
        """Raise UserError where ``pixels`` would; faster."""
        if self.coding == "basis":
            self.pixels()
        elif self.coding == "video":
            check_image(video_picture(self.path, self.layer))
        else:
            check_image(self.path, None if self._is_file() else self._data())

    def _is_file(self) -> bool:
        return self.start == 0 and self.size is None

    def _data(self) -> bytes:
        size = file_stamp(self.path)[0] - self.start if self.size is None else self.size
        return read_stretch(self.path, self.start, size, "a texture")
