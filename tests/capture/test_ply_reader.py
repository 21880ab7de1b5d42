import random
import struct

import numpy as np
import pytest
import trimesh

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.ply_reader import read_ply
from unstructured_mg.capture.texture import Texture

RNG = np.random.default_rng(0)
VERTICES = RNG.normal(size=(6, 3)).astype(np.float32)
UV = RNG.random((6, 2)).astype(np.float32)
COLORS = RNG.integers(0, 256, (6, 3), dtype=np.uint8)
TRIANGLES = [[0, 1, 2], [2, 1, 3], [3, 4, 5]]
POLYGONS = [[0, 1, 2], [2, 1, 3, 4], [0, 3, 5], [0, 1, 2, 4, 5]]
CODES = {"uchar": "B", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"}
FORMATS = ["ascii", "binary_little_endian", "binary_big_endian"]


def ply(form, elements, comments=(), newline="\n"):
    """The bytes of a PLY file. ``elements``: name, properties (type, name) or (count type, type, name), rows."""
    lines = ["ply", f"format {form} 1.0", *(f"comment {comment}" for comment in comments)]
    body = b""
    for name, properties, rows in elements:
        lines.append(f"element {name} {len(rows)}")
        lines += [f"property {'list ' if len(item) == 3 else ''}{' '.join(item)}" for item in properties]
        for row in rows:
            words = []
            for item, value in zip(properties, row, strict=True):
                values = (
                    [(item[0], len(value)), *((item[1], x) for x in value)] if len(item) == 3 else [(item[0], value)]
                )
                words += values
            if form == "ascii":
                body += (
                    " ".join(repr(float(x)) if CODES[k] in "fd" else str(int(x)) for k, x in words) + newline
                ).encode()
            else:
                order = "<" if "little" in form else ">"
                body += b"".join(struct.pack(order + CODES[k], x if CODES[k] in "fd" else int(x)) for k, x in words)
    return (newline.join([*lines, "end_header"]) + newline).encode() + body


XYZ = [("float", axis) for axis in "xyz"]
INDICES = ("uchar", "int", "vertex_indices")


def read(tmp_path, data, name="frame_1.ply"):
    path = tmp_path / name
    path.write_bytes(data)
    return read_ply(path, tmp_path)


def fans(polygons):
    return [[p[0], p[i], p[i + 1]] for p in polygons for i in range(1, len(p) - 1)]


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("names", [("s", "t"), ("u", "v"), ("texture_u", "texture_v")])
def test_uv_a_vertex_colours_and_normals_between(tmp_path, form, names):
    properties = [
        *XYZ,
        ("float", "nx"),
        *(("uchar", c) for c in ("red", "green", "blue", "alpha")),
        *(("float", n) for n in names),
    ]
    rows = [[*v, 0.5, *c, 255, *t] for v, c, t in zip(VERTICES, COLORS, UV, strict=True)]
    raw = read(tmp_path, ply(form, [("vertex", properties, rows), ("face", [INDICES], [[t] for t in TRIANGLES])]))
    np.testing.assert_array_equal(raw.vertices, VERTICES)
    np.testing.assert_array_equal(raw.uv, UV)
    np.testing.assert_array_equal(raw.colors, COLORS)
    np.testing.assert_array_equal(raw.faces, TRIANGLES)
    np.testing.assert_array_equal(raw.face_uv, TRIANGLES)
    assert raw.images == () and (raw.face_image == -1).all()


@pytest.mark.parametrize("form", FORMATS)
def test_polygons_with_uv_a_corner_and_several_images(tmp_path, form):
    for name in ("skin of a.png", "b.png"):
        (tmp_path / name).write_bytes(b"image")
    wedges = [RNG.random((len(p), 2)).astype(np.float32) for p in POLYGONS]
    wedges[2] = wedges[2][:0]
    faces = ("face", [INDICES, ("uchar", "float", "texcoord"), ("int", "texnumber")], [
        [p, w.ravel(), number] for p, w, number in zip(POLYGONS, wedges, [0, 1, 0, 1], strict=True)
    ])  # fmt: skip
    edges = ("edge", [("int", "vertex1"), ("uchar", "float", "weights")], [[1, [0.5] * (i % 3)] for i in range(4)])
    comments = ["TextureFile skin of a.png", "made by hand", "TextureFile b.png"]
    data = ply(form, [("vertex", XYZ, VERTICES), edges, faces], comments, "\r\n" if form == "ascii" else "\n")
    raw = read(tmp_path, data)
    np.testing.assert_array_equal(raw.faces, fans(POLYGONS))
    assert [image.path.name for image in raw.images] == ["skin of a.png", "b.png"]
    np.testing.assert_array_equal(raw.face_image, [0, 1, 1, 0, 1, 1, 1])
    corner = fans([list(range(len(p))) for p in POLYGONS])
    polygon = [0, 1, 1, 2, 3, 3, 3]
    for uvs, corners, p in zip(raw.face_uv, corner, polygon, strict=True):
        if p == 2:
            assert (uvs == -1).all()
        else:
            np.testing.assert_array_equal(raw.uv[uvs], wedges[p][corners])


def test_agrees_with_trimesh_both_ways(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=2)
    for encoding in ("ascii", "binary"):
        raw = read(tmp_path, ball.export(file_type="ply", encoding=encoding))
        np.testing.assert_allclose(raw.vertices, ball.vertices, atol=1e-6)
        np.testing.assert_array_equal(raw.faces, ball.faces)


def test_colours_as_shares_and_as_deep_integers(tmp_path):
    rows = [[*v, *c] for v, c in zip(VERTICES, COLORS / 255, strict=True)]
    properties = [*XYZ, *(("float", c) for c in ("red", "green", "blue"))]
    face = ("face", [INDICES], [[t] for t in TRIANGLES])
    for form in FORMATS:
        np.testing.assert_array_equal(read(tmp_path, ply(form, [("vertex", properties, rows), face])).colors, COLORS)
    properties = [*XYZ, *(("ushort", c) for c in ("red", "green", "blue"))]
    rows = [[*v, *c] for v, c in zip(VERTICES, COLORS.astype(int) * 257, strict=True)]
    np.testing.assert_array_equal(read(tmp_path, ply(FORMATS[1], [("vertex", properties, rows), face])).colors, COLORS)


def test_image_of_the_same_stem_and_paths_outside(tmp_path):
    folder = tmp_path / "capture"
    folder.mkdir()
    (tmp_path / "secret.png").write_bytes(b"image")
    body = [("vertex", XYZ, VERTICES), ("face", [INDICES], [[t] for t in TRIANGLES])]
    (folder / "frame_1.png").write_bytes(b"image")
    assert read(folder, ply("ascii", body)).images == (Texture(folder / "frame_1.png"),)
    with pytest.raises(FrameError, match="leads outside the capture folder"):
        read(folder, ply("ascii", body, ["TextureFile ../secret.png"]))
    with pytest.raises(FrameError, match='its texture "lost.png" is not there'):
        read(folder, ply("ascii", body, ["TextureFile lost.png"]))


@pytest.mark.parametrize("form", FORMATS)
def test_malformed_files_say_what_is_wrong(tmp_path, form):
    vertex, face = ("vertex", XYZ, VERTICES), ("face", [INDICES], [[t] for t in TRIANGLES])
    cases = {
        "it holds no faces": [vertex],
        "it holds no vertices": [("vertex", XYZ, []), face],
        "a face names vertex 6, but there are 6": [vertex, ("face", [INDICES], [[[0, 1, 6]]])],
        "a face names vertex -1,": [vertex, ("face", [INDICES], [[[0, 1, -1]]])],
        "face 1 has fewer than three corners": [vertex, ("face", [INDICES], [[[0, 1, 2]], [[3, 4]]])],
        "does not fit": [vertex, ("face", [INDICES, ("uchar", "float", "texcoord")], [[[0, 1, 2], [0.5, 0.5]]])],
    }
    for fault, elements in cases.items():
        with pytest.raises(FrameError, match=fault):
            read(tmp_path, ply(form, elements))
    whole = ply(form, [vertex, face])
    for end in range(len(whole) - 3):
        with pytest.raises(FrameError):
            read(tmp_path, whole[:end])
    for old, new in (
        (b"vertex 6", b"vertex 999999999999"),
        (b"face 3", b"face -3"),
        (b"float x", b"quad x"),
        (b"float y", b"float x"),
    ):
        with pytest.raises(FrameError):
            read(tmp_path, whole.replace(old, new))


def test_damaged_bytes_are_refused_or_read_in_range(tmp_path):
    rng = random.Random(0)
    for form in FORMATS:
        whole = ply(form, [("vertex", XYZ, VERTICES), ("face", [INDICES], [[p] for p in POLYGONS])])
        for _ in range(150):
            damaged = bytearray(whole)
            for _ in range(rng.randrange(1, 4)):
                damaged[rng.randrange(len(damaged))] = rng.choice([0, 45, 49, 57, 127, 255, rng.randrange(256)])
            try:
                raw = read(tmp_path, bytes(damaged))
            except FrameError:
                continue
            assert raw.faces.min() >= 0 and raw.faces.max() < len(raw.vertices)
