"""What holds for all inputs of a grammar, found out by hypothesis."""

import json
import os
import tempfile
import zipfile
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from toy_capture import toy_capture

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.obj_reader import read_obj
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.array_file import read_arrays
from unstructured_mg.pipeline.choices import read_choices

EXAMPLES = settings(
    max_examples=4 * int(os.environ.get("UMG_FUZZ_CASES", "15")), deadline=None, derandomize=True, database=None
)
NUMBER = st.one_of(
    st.integers(-5, 9).map(str), st.floats().map(repr), st.sampled_from(["-0", "1e999", "0x1", ".", "--1"])
)
INDEX = st.one_of(
    st.integers(-9, 9).map(str), st.sampled_from(["2147483648", "99999999999999999999", "1/", "/1", "1//1"])
)
LINE = st.one_of(
    st.lists(NUMBER, max_size=8).map(lambda words: "v " + " ".join(words)),
    st.lists(NUMBER, max_size=4).map(lambda words: "vt " + " ".join(words)),
    st.lists(st.tuples(INDEX, INDEX).map("/".join) | INDEX, max_size=6).map(lambda words: "f " + " ".join(words)),
    st.sampled_from(["usemtl x", "mtllib y.mtl", "#", "o", "\\", "", "f", "v 0 0 0", "v 1 0 0", "v 0 1 0", "f 1 2 3"]),
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4) | st.sampled_from(["1", "40"]),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["pins", "vetoes", "x"]), inner, max_size=3)
    ),
    max_leaves=12,
)


@EXAMPLES
@given(st.lists(LINE, max_size=30), st.sampled_from(["\n", "\r\n", "\r"]))
def test_an_obj_is_read_in_range_or_refused_by_name(lines, newline):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "frame_1.obj"
        path.write_bytes(newline.join(lines).encode())
        try:
            raw = read_obj(path, path.parent)
        except FrameError as error:
            assert error.file == path and error.fault and error.remedy
            return
    wanted = sum(line.split()[:1] == ["v"] for line in lines)
    assert len(raw.vertices) == wanted and 0 <= raw.faces.min() <= raw.faces.max() < wanted
    assert raw.face_uv.size == 0 or 0 <= raw.face_uv.min() <= raw.face_uv.max() < len(raw.uv)


@EXAMPLES
@given(JSON)
def test_any_json_is_pairs_json_or_refused_by_name(content):
    capture = toy_capture(60)
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "pairs.json"
        path.write_text(json.dumps(content))
        try:
            found = read_choices(path, capture, None)
        except UserError as error:
            assert str(path) in str(error)
            return
    assert all(0 <= s <= t < 60 for s, t in found.pins + found.vetoes)


@EXAMPLES
@given(st.binary(max_size=200), st.integers(0, 10**30), st.sampled_from(["<f8", "|O", "<i4", "V8", "<U9999999"]))
def test_any_header_of_an_array_is_refused_or_read(body, length, kind):
    """A header that says what it likes, before a body that is what it is."""
    head = str({"descr": kind, "fortran_order": False, "shape": (length, 3)}).encode()
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "a.npz"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("vertices.npy", b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head + body)
        try:
            found = read_arrays(path, {"vertices": ("float64", ("n", 3), None)})["vertices"]
        except UserError as error:
            assert str(path) in str(error)
            return
    np.testing.assert_array_equal(found.ravel(), np.frombuffer(body))
    assert len(found) == length
