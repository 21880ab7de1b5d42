import io

import numpy as np
from PIL import Image

from unstructured_mg.playback.smaller_texture import smaller_texture
from unstructured_mg.playback.stream import EncodedImage


def encoded(pixels, kind):
    data = io.BytesIO()
    Image.fromarray(pixels).save(data, kind, **({"quality": 95, "subsampling": 0} if kind == "JPEG" else {}))
    return EncodedImage(data.getvalue(), ".jpg" if kind == "JPEG" else ".png")


def decoded(texture):
    with Image.open(io.BytesIO(texture.data)) as image:
        return image.format, np.asarray(image.convert("RGB")).astype(float)


def slope(height, width):
    y, x = np.mgrid[:height, :width]
    return np.stack([255 * (x + 0.5) / width, 255 * (y + 0.5) / height, np.full((height, width), 90)], 2).astype(
        np.uint8
    )


def test_what_is_small_enough_keeps_its_bytes():
    texture = encoded(slope(20, 40), "JPEG")
    assert smaller_texture(texture, 40) is texture


def test_a_smaller_texture_shows_the_same_in_proportion():
    for kind, suffix, allowed in (("JPEG", ".jpg", 8.0), ("PNG", ".png", 2.0)):
        small = smaller_texture(encoded(slope(64, 128), kind), 32)
        shape, pixels = decoded(small)
        assert (small.suffix, shape, pixels.shape) == (suffix, kind, (16, 32, 3))
        assert np.abs(pixels - slope(16, 32)).max() <= allowed


def test_transparency_is_dropped_and_a_line_stays_one_pixel():
    pixels = np.zeros((2, 400, 4), np.uint8)
    pixels[..., 1] = 200
    shape, small = decoded(smaller_texture(encoded(pixels, "PNG"), 100))
    assert shape == "PNG" and small.shape == (1, 100, 3) and (small == [0, 200, 0]).all()
