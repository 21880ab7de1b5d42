import random

import numpy as np
import pytest
from real_captures import real_capture

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.obj_reader import read_obj
from unstructured_mg.capture.texture import Texture

BOX = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def reference(text):
    """A plain OBJ parser: positions, uvs, triangles, their uvs (-1: none); ValueError where the text is malformed."""
    vertices, uvs, faces, face_uvs = [], [], [], []
    lines = [line.split("#")[0].split() for line in text.split("\n")]
    vertex_count = sum(words[:1] == ["v"] for words in lines)
    uv_count = sum(words[:1] == ["vt"] for words in lines)

    def resolve(word, so_far, total):
        index = int(word)
        index = index - 1 if index > 0 else so_far + index if index < 0 else -1
        if not 0 <= index < total:
            raise ValueError(word)
        return index

    for words in lines:
        if words[:1] == ["v"]:
            vertices.append([float(word) for word in words[1:7]][:3])
            if len(vertices[-1]) < 3:
                raise ValueError(words)
        elif words[:1] == ["vt"]:
            uvs.append([*(float(word) for word in words[1:3]), 0.0][:2])
            if len(words) < 2:
                raise ValueError(words)
        elif words[:1] == ["f"]:
            corners = []
            for word in words[1:]:
                parts = word.split("/")
                if len(parts) > 3 or any(part and "_" in part for part in parts):
                    raise ValueError(word)
                vertex = resolve(parts[0], len(vertices), vertex_count)
                uv = resolve(parts[1], len(uvs), uv_count) if len(parts) > 1 and parts[1] else -1
                if len(parts) > 2 and parts[2]:
                    int(parts[2])
                corners.append((vertex, uv))
            if len(corners) < 3:
                raise ValueError(words)
            for i in range(1, len(corners) - 1):
                fan = [corners[0], corners[i], corners[i + 1]]
                faces.append([vertex for vertex, _ in fan])
                face_uvs.append([uv for _, uv in fan])
    return np.array(vertices).reshape(-1, 3), np.array(uvs).reshape(-1, 2), np.array(faces), np.array(face_uvs)


def read(tmp_path, text, name="frame_1.obj"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_obj(path, tmp_path)


def random_number(rng):
    return rng.choice(
        [
            f"{rng.uniform(-2, 2):.{rng.randrange(20)}f}",
            repr(rng.uniform(-1, 1)),
            f"{rng.uniform(-1, 1):.17e}",
            f"{rng.uniform(-1e9, 1e9):+g}",
            str(rng.randrange(-(10**25), 10**25)),
            f".{rng.randrange(1000)}",
            f"{rng.randrange(9)}.",
            f"{rng.randrange(9)}e-{rng.randrange(330)}",
            "0.30000000000000004",
            "-0",
        ]
    )


def random_text(rng):
    """A valid OBJ of every kind of line, its indices also negative and ahead of their vertices."""
    vertex_count, uv_count = rng.randrange(3, 20), rng.randrange(0, 20)
    lines = [
        f"v {' '.join(random_number(rng) for _ in range(3))}{rng.choice(['', ' 1', ' 0.1 0.2 0.3'])}"
        for _ in range(vertex_count)
    ]
    lines += [f"vt {' '.join(random_number(rng) for _ in range(rng.choice([1, 2, 3])))}" for _ in range(uv_count)]
    lines += rng.choices(["vn 0 0 1", "# v 1 2 3", "", "o name", "s off", "vp 1 2", "l 1 2", "  "], k=5)
    rng.shuffle(lines)
    seen = 0
    for line in list(lines):
        seen += line.startswith("v ")
    for _ in range(rng.randrange(1, 20)):
        at = rng.randrange(len(lines) + 1)
        so_far = sum(line.startswith("v ") for line in lines[:at])
        corners = []
        for _ in range(rng.randrange(3, 7)):
            vertex = rng.randrange(1, vertex_count + 1)
            corner = str(rng.choice([vertex, vertex - so_far - 1]) if vertex <= so_far else vertex)
            if uv_count:
                corner += rng.choice(["", f"/{rng.randrange(1, uv_count + 1)}", f"/{rng.randrange(1, uv_count + 1)}/7"])
            else:
                corner += rng.choice(["", "//3"])
            corners.append(corner)
        lines.insert(
            at, f"f{rng.choice([' ', '  ', chr(9)])}{' '.join(corners)}{rng.choice(['', ' ', ' # a comment'])}"
        )
    return "\n".join(lines) + rng.choice(["", "\n"])


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_valid_text_reads_as_the_reference_parser_reads_it_to_the_last_bit(tmp_path, newline):
    rng = random.Random(1)
    for _ in range(200):
        text = random_text(rng)
        raw = read(tmp_path, text.replace("\n", newline))
        vertices, uv, faces, face_uv = reference(text)
        np.testing.assert_array_equal(raw.vertices, vertices)
        np.testing.assert_array_equal(raw.uv, uv)
        np.testing.assert_array_equal(raw.faces, faces)
        np.testing.assert_array_equal(raw.face_uv, face_uv)


def test_damaged_text_is_refused_where_the_reference_refuses_it_and_never_read_differently(tmp_path):
    rng = random.Random(2)
    refused = 0
    for _ in range(600):
        text = random_text(rng)
        kind = rng.randrange(3)
        at = rng.randrange(len(text))
        if kind == 0:
            text = text[:at]
        elif kind == 1:
            text = (
                text[:at]
                + rng.choice(["-", "/", " ", "9999999999999999999999", ".", "e", "x", "\n", "nan "])
                + text[at:]
            )
        else:
            text = text[:at] + text[at + rng.randrange(1, 9) :]
        try:
            expected = reference(text)
            if len(expected[0]) == 0 or len(expected[2]) == 0:
                raise ValueError
        except ValueError:
            refused += 1
            with pytest.raises(FrameError):
                read(tmp_path, text)
            continue
        raw = read(tmp_path, text)
        finite = np.isfinite(expected[0])
        np.testing.assert_array_equal(raw.vertices[finite], expected[0][finite])
        assert not np.isfinite(raw.vertices[~finite]).any()
        np.testing.assert_array_equal(raw.faces, expected[2])
        np.testing.assert_array_equal(raw.face_uv, expected[3])
    assert 100 < refused < 500


def test_random_bytes_are_refused_or_read_but_never_crash(tmp_path):
    rng = random.Random(3)
    for _ in range(300):
        words = [
            rng.choice(
                [
                    b"v ",
                    b"f ",
                    b"vt ",
                    b"\n",
                    b"1 ",
                    b"-3/2 ",
                    b"usemtl",
                    b"mtllib ",
                    b"\x00",
                    b"\xff",
                    b"/",
                    b"e9",
                    b"#",
                ]
            )
        ]
        words += rng.choices(
            words + [b"\n", b"v 1 2 3\n", b"f 1 2 3\n", bytes(rng.randrange(256) for _ in range(9))], k=200
        )
        try:
            raw = read(tmp_path, b"".join(words))
        except FrameError:
            continue
        assert raw.faces.min() >= 0 and raw.faces.max() < len(raw.vertices)
        assert raw.face_uv.min() >= -1 and raw.face_uv.max() < max(len(raw.uv), 1)


@pytest.mark.parametrize(
    "text, fault",
    [
        ("", "the file is empty"),
        ("hello\nworld\n", "no vertices"),
        (BOX, "no faces"),
        ("f 1 2 3\n", "no vertices"),
        (BOX + "f 1 2 5\n", "line 5 names vertex 5,"),
        (BOX + "f 1 2 99999999999999999999999\n", "line 5 names vertex"),
        (BOX + "f 1 2 0\n", "line 5 names vertex 0,"),
        (BOX + "f 1 2 -5\n", "line 5 names vertex -5,"),
        (BOX + "vt 0 0\nf 1/1 2/1 3/2\n", "line 6 names texture coordinate 2,"),
        (BOX + "f 1 2 3\nf 1 2\n", "line 6 holds a face of fewer than three corners"),
        (BOX + "f 1 2 3x\n", "line 5 holds a face corner that is no index"),
        ("v\n" * 99 + "f 1 2 3\n", "its vertex lines do not hold three numbers each"),
        ("v 1 2\n" + BOX + "f 1 2 3\n", "line 1 does not hold the numbers"),
        ("v 1,5 2 3\n" + BOX + "f 1 2 3\n", "line 1 does not hold the numbers"),
    ],
)
def test_malformed_files_say_where_and_why(tmp_path, text, fault):
    with pytest.raises(FrameError) as error:
        read(tmp_path, text)
    assert fault in error.value.fault and str(tmp_path / "frame_1.obj") in str(error.value)


@pytest.mark.parametrize("word", ["nan", "-NaN", "inf", "-nan(ind)", "1.#QNAN", "Infinity"])
def test_what_printers_write_for_no_number_is_nan(tmp_path, word):
    raw = read(tmp_path, f"v {word} 0 0\n{BOX}f 1 2 3\n")
    assert np.isnan(raw.vertices[0, 0]) and np.isfinite(raw.vertices.ravel()[1:]).all()


def test_colours_in_either_range_and_white_where_missing(tmp_path):
    raw = read(tmp_path, "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 1\nv 0 1 0\nf 1 2 3")
    np.testing.assert_array_equal(raw.colors, [[255, 128, 0], [0, 0, 255], [255, 255, 255]])
    raw = read(tmp_path, "v 0 0 0 255 128 0\nv 1 0 0 0 0 255\nv 0 1 0 7 7 7\nf 1 2 3")
    np.testing.assert_array_equal(raw.colors, [[255, 128, 0], [0, 0, 255], [7, 7, 7]])
    assert read(tmp_path, BOX + "f 1 2 3").colors is None


def test_continued_lines_old_mac_line_ends_and_byte_order_mark(tmp_path):
    expected = read(tmp_path, BOX + "f 1 2 3 4\n").faces
    np.testing.assert_array_equal(read(tmp_path, BOX + "f 1 2 \\\n 3 \\\r\n 4").faces, expected)
    np.testing.assert_array_equal(read(tmp_path, (BOX + "f 1 2 3 4\n").replace("\n", "\r")).faces, expected)
    np.testing.assert_array_equal(read(tmp_path, b"\xef\xbb\xbf" + (BOX + "f 1 2 3 4\n").encode()).faces, expected)


MAPPED = BOX + "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


def test_materials_images_and_libraries_are_found_whatever_their_names(tmp_path):
    (tmp_path / "Maps of cloth").mkdir()
    cloth, skin = tmp_path / "Maps of cloth" / "Red Cloth.PNG", tmp_path / "skin.jpg"
    for path in (cloth, skin):
        path.write_bytes(b"image")
    (tmp_path / "My Frame.MTL").write_bytes(
        b"newmtl cloth\r\n\tmap_Kd -s 1 1 1 -blendu on -o 0 0 maps of cloth\\red cloth.png\r\n"
        b"newmtl some skin\nmap_Ka other.jpg\nmap_Kd -clamp on skin.jpg\nnewmtl unused\nmap_Kd /etc/passwd\n"
    )
    raw = read(
        tmp_path,
        "mtllib my frame.mtl\n"
        + MAPPED
        + "usemtl some skin\nf 1/1 2/2 3/3\nusemtl cloth\nf 1/1 3/3 4/4\nusemtl some skin\nf 1 2 4\n",
    )
    assert {image.path for image in raw.images} == {cloth, skin}
    assert [raw.images[i].path.name for i in raw.face_image] == ["skin.jpg", "Red Cloth.PNG", "skin.jpg"]
    assert raw.files[:2] == (tmp_path / "frame_1.obj", tmp_path / "My Frame.MTL")


def test_an_image_of_the_same_stem_serves_where_no_material_names_one(tmp_path):
    assert read(tmp_path, MAPPED + "f 1/1 2/2 3/3").images == ()
    (tmp_path / "frame_1.JPG").write_bytes(b"image")
    raw = read(tmp_path, MAPPED + "f 1/1 2/2 3/3")
    assert raw.images == (Texture(tmp_path / "frame_1.JPG"),) and (raw.face_image == 0).all()
    assert read(tmp_path, "mtllib lost.mtl\n" + MAPPED + "usemtl a\nf 1/1 2/2 3/3").images == raw.images


def test_a_named_image_that_is_not_there_is_a_fault(tmp_path):
    (tmp_path / "frame_1.mtl").write_text("newmtl m\nmap_Kd lost.png\n")
    (tmp_path / "frame_1.png").write_bytes(b"image")
    with pytest.raises(FrameError, match='its texture "lost.png" is not there'):
        read(tmp_path, "mtllib frame_1.mtl\n" + MAPPED + "usemtl m\nf 1/1 2/2 3/3")


@pytest.mark.parametrize(
    "name",
    ["../secret.png", "{outside}/secret.png", "C:\\secret.png", "link.png", "..\\secret.png", "sub/../../secret.png"],
)
def test_paths_that_lead_outside_the_capture_are_refused(tmp_path, name):
    outside, folder = tmp_path, tmp_path / "capture"
    folder.mkdir()
    (outside / "secret.png").write_bytes(b"image")
    (folder / "link.png").symlink_to(outside / "secret.png")
    (folder / "frame_1.mtl").write_text(f"newmtl m\nmap_Kd {name.format(outside=outside)}\n")
    for text in (
        "mtllib frame_1.mtl\n" + MAPPED + "usemtl m\nf 1/1 2/2 3/3",
        "mtllib ../frame_1.mtl\n" + MAPPED + "f 1 2 3",
    ):
        with pytest.raises(FrameError, match="leads outside the capture folder"):
            read(folder, text)


def test_a_capture_of_symbolic_links_to_frames_is_read_where_they_lie(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "links").mkdir()
    (tmp_path / "real" / "frame_1.png").write_bytes(b"image")
    (tmp_path / "real" / "frame_1.mtl").write_text("newmtl m\nmap_Kd frame_1.png\n")
    (tmp_path / "real" / "frame_1.obj").write_text("mtllib frame_1.mtl\n" + MAPPED + "usemtl m\nf 1/1 2/2 3/3")
    for name in ("frame_1.png", "frame_1.mtl", "frame_1.obj"):
        (tmp_path / "links" / name).symlink_to(tmp_path / "real" / name)
    raw = read_obj(tmp_path / "links" / "frame_1.obj", tmp_path / "links")
    assert raw.images == (Texture(tmp_path / "links" / "frame_1.png"),)


def test_a_real_frame_reads_as_the_reference_reads_it(tmp_path):
    folder = real_capture("liam", "0:2")
    path = folder / "frame_0000.obj"
    raw = read_obj(path, folder)
    vertices, uv, faces, face_uv = reference(path.read_text())
    np.testing.assert_array_equal(raw.vertices, vertices)
    np.testing.assert_array_equal(raw.uv, uv)
    np.testing.assert_array_equal(raw.faces, faces)
    np.testing.assert_array_equal(raw.face_uv, face_uv)
