import numpy as np
import pytest
from site_reader import script_data

from unstructured_mg.playback.site_codec import column, columns, script


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.uint32])
def test_a_column_is_the_sum_of_its_differences(kind):
    """Also where differences wrap around; decoded as docs/files.md says."""
    top = np.iinfo(kind).max
    values = np.random.default_rng(0).integers(0, top, 300, endpoint=True).astype(kind)
    values[:4] = top, 0, top, top // 2
    size = values.itemsize
    planes = np.frombuffer(column(values), np.uint8).reshape(size, -1).astype(np.int64)
    folded = sum(plane << (8 * place) for place, plane in enumerate(planes))
    steps = np.where(folded % 2, -(folded + 1) // 2, folded // 2)
    np.testing.assert_array_equal(np.cumsum(steps) % (top + 1), values)


def test_small_steps_have_small_bytes():
    assert column(np.array([5, 4, 4, 6], np.uint16)) == bytes([10, 1, 0, 4, 0, 0, 0, 0])
    assert columns(np.array([[5, 1], [4, 2]], np.uint8)) == bytes([10, 1, 2, 2])


def test_a_script_gives_back_every_byte():
    """All 256 bytes and their neighbourhoods, after deflating: random bytes stay as they are in the stream."""
    noise = np.random.default_rng(1).integers(0, 256, 200_000).astype(np.uint8).tobytes()
    name, data = script_data(script("frames/a", {"frame": "a"}, [noise, b"end"]))
    assert name == "frames/a"
    assert data == (13).to_bytes(4, "little") + b'{"frame":"a"}' + noise + b"end"
