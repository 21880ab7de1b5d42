import io
import pickle
import zipfile

import numpy as np
import pytest

from unstructured_mg.errors import UserError
from unstructured_mg.geometry.array_file import read_arrays, read_json

MESH = {"vertices": ("float64", ("n", 3), None), "faces": ("int32", ("m", 3), "n")}
ARRAYS = {"vertices": np.arange(12.0).reshape(4, 3), "faces": np.array([[0, 1, 2], [1, 2, 3]], np.int32)}


def test_what_numpy_wrote_is_read_as_numpy_reads_it(tmp_path):
    path = tmp_path / "a.npz"
    arrays = {**ARRAYS, "vertices": np.asfortranarray(ARRAYS["vertices"]), "measure_x": np.ones(2), "other": np.ones(1)}
    np.savez(path, **arrays)
    found = read_arrays(path, MESH, {"colors": ("uint8", ("n", 3), None), "measure_*": ("float64", ("f",), None)})
    assert list(found) == ["vertices", "faces", "measure_x"]
    for name, array in found.items():
        np.testing.assert_array_equal(array, arrays[name])
        assert array.dtype == arrays[name].dtype and array.flags.writeable


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"faces": None}, "faces is missing"),
        ({"faces": ARRAYS["faces"].astype(np.int64)}, "faces: expected int32, got int64"),
        ({"vertices": ARRAYS["vertices"].T}, "vertices: expected"),
        ({"faces": ARRAYS["faces"] - 1}, "faces holds an index out of 0 to 3"),
        ({"faces": ARRAYS["faces"] + 1}, "faces holds an index out of 0 to 3"),
        ({"vertices": np.zeros((0, 3))}, "faces holds an index"),
        ({"vertices": np.array([[print, 0, 0]], object)}, "vertices: expected float64, got object"),
    ],
)
def test_what_does_not_fit_is_named(tmp_path, change, words):
    path = tmp_path / "a.npz"
    np.savez(path, **{name: array for name, array in {**ARRAYS, **change}.items() if array is not None})
    with pytest.raises(UserError, match=words) as caught:
        read_arrays(path, MESH)
    assert str(caught.value).startswith(f"{path}: ")


def promising(shape, kind="<f8"):
    """A header that promises an array of that shape, and no body."""
    head = str({"descr": kind, "fortran_order": False, "shape": shape}).encode()
    return b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head


@pytest.mark.parametrize(
    ("member", "compression"),
    [
        (promising((10**12, 3)), zipfile.ZIP_STORED),
        (promising((2**62, 2**62, 3)), zipfile.ZIP_STORED),
        (promising((-4, 3)), zipfile.ZIP_STORED),
        (promising((4, 3), "|O") + pickle.dumps([1] * 12), zipfile.ZIP_STORED),
        (promising((10**5, 3)) + bytes(24 * 10**5), zipfile.ZIP_DEFLATED),
        (b"\x93NUMPY\x09\x00", zipfile.ZIP_STORED),
        (b"", zipfile.ZIP_STORED),
    ],
)
def test_promises_of_billions_and_pickles_are_not_followed(tmp_path, member, compression):
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w", compression) as archive:
        archive.writestr("vertices.npy", member)
        buffer = io.BytesIO()
        np.save(buffer, ARRAYS["faces"])
        archive.writestr("faces.npy", buffer.getvalue())
    with pytest.raises(UserError, match="is not what umg wrote there"):
        read_arrays(path, MESH)


@pytest.mark.parametrize("text", [b"", b"{", b'{"a": NaN}', b'{"a": Infinity}', b"\xff", b"[" * 100_000])
def test_no_json_is_named(tmp_path, text):
    path = tmp_path / "a.json"
    path.write_bytes(text)
    with pytest.raises(UserError, match="is not what umg wrote there"):
        read_json(path)
    with pytest.raises(UserError, match="is missing"):
        read_json(tmp_path / "none.json")
