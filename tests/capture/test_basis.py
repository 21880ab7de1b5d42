import random
import struct
from pathlib import Path

import numpy as np
import pytest
from sequence_samples import ETC1S_BASIS, ETC1S_VIDEO, UASTC_ARRAY, layer_picture

from unstructured_mg.capture.basis import check_basis, read_basis
from unstructured_mg.capture.frame_error import FrameError

FILE = Path("a.ktx2")


@pytest.mark.parametrize("data, layers, worst", [(ETC1S_VIDEO, 3, 20), (UASTC_ARRAY, 2, 3), (ETC1S_BASIS, 1, 20)])
def test_every_layer_is_what_was_encoded(data, layers, worst):
    assert check_basis(FILE, 0, data) == (16, 8, layers)
    for layer in reversed(range(layers)):
        pixels = read_basis(FILE, 0, data, layer)
        assert pixels.shape == (8, 16, 3) and pixels.dtype == np.uint8
        assert np.abs(pixels.astype(int) - layer_picture(layer)).max() <= worst
    with pytest.raises(FrameError, match=f"its texture has {layers} layers, but the frame needs number {layers + 1}"):
        read_basis(FILE, 0, data, layers)


@pytest.mark.parametrize(
    "at, form, value, fault",
    [
        (0, "B", 0, "byte 100: expected a KTX2 texture"),
        (20, "I", 2**32 - 1, "byte 120: expected a width in pixels, found 4294967295"),
        (24, "I", 1 << 24, "byte 120: its texture has 16 x 16777216 pixels"),
        (28, "I", 5, "byte 128: expected a flat texture"),
        (32, "I", 2**31, "byte 132: expected a number of layers, found 2147483648"),
        (40, "I", 2**31, "byte 140: expected a number of levels"),
        (72, "Q", 2**40, "byte 164: the texture's codebook should reach to byte"),
        (80, "Q", 2**63, "byte 180: the texture's level 0 should reach to byte"),
    ],
)
def test_a_lying_header_names_the_byte_in_the_file(at, form, value, fault):
    data = bytearray(ETC1S_VIDEO)
    struct.pack_into("<" + form, data, at, value)
    with pytest.raises(FrameError, match=fault):
        read_basis(FILE, 100, bytes(data), 0)


def test_cut_off_and_damaged_bytes_are_faults_or_pixels():
    rng = random.Random(0)
    for sample in (ETC1S_VIDEO, UASTC_ARRAY, ETC1S_BASIS):
        for end in range(0, len(sample), 3):
            with pytest.raises(FrameError, match="byte"):
                read_basis(FILE, 0, sample[:end], 0)
        for _ in range(200):
            damaged = bytearray(sample)
            for _ in range(rng.randrange(1, 4)):
                damaged[rng.randrange(len(damaged))] = rng.choice([0, 127, 255, rng.randrange(256)])
            try:
                pixels = read_basis(FILE, 0, bytes(damaged), 0)
            except FrameError:
                continue
            assert pixels.ndim == 3 and pixels.dtype == np.uint8
