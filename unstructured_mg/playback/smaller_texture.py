"""Textures with fewer pixels, for exports that must be light."""

import io

from PIL import Image

from unstructured_mg.playback.stream import EncodedImage

# Of re-encoded JPEG, at full colour resolution: charts lie close together, and colours must not run between them.
JPEG_QUALITY = 92


def smaller_texture(texture: EncodedImage, largest: int) -> EncodedImage:
    """A texture whose longer side has at most ``largest`` pixels; the same bytes where it has already.

    JPEG stays JPEG, anything else becomes PNG. Pixels are averaged, in proportion (Lanczos).
    """
    with Image.open(io.BytesIO(texture.data)) as image:
        if max(image.size) <= largest:
            return texture
        width, height = (max(1, round(side * largest / max(image.size))) for side in image.size)
        jpeg = image.format == "JPEG"
        pixels = image.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)
    data = io.BytesIO()
    if jpeg:
        pixels.save(data, "JPEG", quality=JPEG_QUALITY, subsampling=0)
    else:
        pixels.save(data, "PNG")
    return EncodedImage(data.getvalue(), ".jpg" if jpeg else ".png")
