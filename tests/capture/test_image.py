import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from unstructured_mg.capture.image import check_image, image_size, read_image
from unstructured_mg.errors import UserError

GREY = np.arange(12, dtype=np.uint8).reshape(3, 4) * 20
COLOR = np.stack([GREY, GREY[::-1], 255 - GREY], axis=2)


def test_every_kind_of_pixel_becomes_rgb_bytes(tmp_path):
    alpha = np.full((3, 4, 1), 7, np.uint8)
    palette = Image.fromarray(COLOR).quantize(12)
    cases = {
        "grey.png": (Image.fromarray(GREY), np.repeat(GREY[:, :, None], 3, axis=2)),
        "grey alpha.png": (
            Image.fromarray(np.concatenate([GREY[:, :, None], alpha], axis=2), "LA"),
            np.repeat(GREY[:, :, None], 3, axis=2),
        ),
        "alpha.png": (Image.fromarray(np.concatenate([COLOR, alpha], axis=2)), COLOR),
        "deep.png": (Image.fromarray(GREY.astype(np.uint16) * 257), np.repeat(GREY[:, :, None], 3, axis=2)),
        "deep.tif": (Image.fromarray(GREY.astype(np.uint16) * 257), np.repeat(GREY[:, :, None], 3, axis=2)),
        "real.tif": (Image.fromarray(GREY.astype(np.float32) / 255), np.repeat(GREY[:, :, None], 3, axis=2)),
        "palette.png": (palette, np.asarray(palette.convert("RGB"))),
        "one bit.png": (Image.fromarray(GREY > 100), np.repeat((GREY[:, :, None] > 100) * np.uint8(255), 3, axis=2)),
        "color.bmp": (Image.fromarray(COLOR), COLOR),
        "color.tga": (Image.fromarray(COLOR), COLOR),
        "inks.tif": (Image.fromarray(255 - COLOR).convert("CMYK"), 255 - COLOR),
    }
    for name, (image, expected) in cases.items():
        image.save(tmp_path / name)
        pixels = read_image(tmp_path / name)
        assert pixels.dtype == np.uint8 and pixels.shape == (3, 4, 3), name
        assert np.abs(pixels.astype(int) - expected).max() <= (1 if name == "real.tif" else 0), name
        assert check_image(tmp_path / name) == image_size(tmp_path / name) == (4, 3), name


def test_jpeg_also_of_four_inks_and_not_turned_by_its_exif(tmp_path):
    smooth = np.tile(np.linspace(40, 200, 64).astype(np.uint8)[:, None, None], (1, 48, 3))
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.fromarray(smooth).save(tmp_path / "a.jpg", quality=95, exif=exif)
    Image.fromarray(smooth).convert("CMYK").save(tmp_path / "b.jpg", quality=95)
    for name in ("a.jpg", "b.jpg"):
        assert np.abs(read_image(tmp_path / name).astype(int) - smooth).max() <= 4
        assert check_image(tmp_path / name) == (48, 64)


def png_header(width, height):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0" * 99)) + chunk(b"IEND", b"")
    )


@pytest.mark.parametrize("size", [(8193, 8192), (20_000, 20_000), (2**31 - 1, 2**31 - 1)])
def test_bombs_are_refused_unopened(tmp_path, size, recwarn):
    path = tmp_path / "bomb.png"
    path.write_bytes(png_header(*size))
    for reader in (read_image, check_image, image_size):
        with pytest.raises(UserError, match="bomb.png: the image has .* pixels; no texture may exceed 8192 x 8192"):
            reader(path)
    assert not recwarn.list


def test_damaged_images_are_refused_by_reading_and_by_checking(tmp_path):
    rng = np.random.default_rng(0)
    noise = Image.fromarray(rng.integers(0, 256, (64, 64, 3), dtype=np.uint8))
    for name in ("a.png", "a.jpg", "a.bmp", "a.tif", "a.webp"):
        path = tmp_path / name
        noise.save(path)
        whole = path.read_bytes()
        for damaged in (b"", whole[:10], whole[: len(whole) // 2], b"no image at all"):
            path.write_bytes(damaged)
            for reader in (read_image, check_image):
                with pytest.raises(UserError, match=name):
                    reader(path)
    with pytest.raises(UserError, match="there is no such image"):
        read_image(tmp_path / "nowhere.png")


def test_formats_that_start_other_programs_are_not_opened(tmp_path):
    path = tmp_path / "picture.png"
    path.write_bytes(b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\n")
    with pytest.raises(UserError, match="cannot be decoded"):
        read_image(path)
