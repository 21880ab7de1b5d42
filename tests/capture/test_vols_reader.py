import struct

import numpy as np
import pytest
from broken_captures import BODY_FACES, BODY_UV
from sequence_samples import ETC1S_BASIS, ETC1S_VIDEO, layer_picture, moved_body, vols_frame, vols_header, write_video

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.reader import open_capture
from unstructured_mg.capture.vols_reader import open_vols, read_vols

KINDS = [1, 0, 0, 1, 0, 2]


def body(version, kinds=KINDS, normals=False, textures=None):
    return [
        vols_frame(
            version, i, moved_body(i), kind=kind, normals=normals, texture=None if textures is None else textures[i]
        )
        for i, kind in enumerate(kinds)
    ]


@pytest.mark.parametrize("version, normals", [(10, False), (11, True), (12, False), (12, True), (13, True)])
@pytest.mark.parametrize("apart", [True, False])
def test_every_header_and_kind_of_frame(tmp_path, version, normals, apart):
    kinds = KINDS if version >= 12 else KINDS[:5]
    frames = b"".join(body(version, kinds, normals))
    header = vols_header(version, len(kinds), normals=normals)
    path = tmp_path / ("sequence_0.vols" if apart and version < 13 else "take.vols")
    if path.name == "sequence_0.vols":
        (tmp_path / "header.vols").write_bytes(header)
        path.write_bytes(frames)
    else:
        path.write_bytes(header + frames)
    vols = open_vols(path)
    assert [frame.key for frame in vols.frames] == [0, 0, 0, 3, 3, 5][: len(kinds)]
    assert vols.fault is None and vols.fps == (25.0 if version == 13 else None)
    for i in (4, 1, 3):
        raw = read_vols(path, tmp_path, i)
        np.testing.assert_array_equal(raw.vertices, moved_body(i))
        np.testing.assert_array_equal(raw.faces, BODY_FACES)
        np.testing.assert_array_equal(raw.uv[raw.face_uv], BODY_UV.astype(np.float32)[BODY_FACES])


def test_long_indices_from_65535_vertices_on(tmp_path):
    for count in (65534, 65535):
        vertices = np.zeros((count, 3), np.float32)
        faces = np.array([[0, 1, count - 1]])
        path = tmp_path / f"take{count}.vols"
        path.write_bytes(vols_header(13, 1) + vols_frame(13, 0, vertices, kind=1, faces=faces, uv=np.zeros((count, 2))))
        np.testing.assert_array_equal(read_vols(path, tmp_path, 0).faces, faces)


def test_a_vologram_with_textures_inside_is_a_capture(tmp_path):
    frames = body(13, textures=[ETC1S_BASIS, ETC1S_VIDEO] * 3)
    (tmp_path / "take.vols").write_bytes(vols_header(13, 6, textured=True) + b"".join(frames))
    capture = open_capture(tmp_path)
    assert len(capture) == 6 and capture.fps == 25 and not capture.faults and capture.up == "y"
    difference = np.abs(capture.read(2).textures[0].pixels().astype(int) - layer_picture(0))
    assert difference.max() <= 20
    assert len({frame.sha256 for frame in capture.frames}) == 6


def test_a_video_beside_the_frames_is_their_texture(tmp_path, monkeypatch):
    monkeypatch.setenv("UMG_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "take"
    folder.mkdir()
    (folder / "header.vols").write_bytes(vols_header(12, 6))
    (folder / "sequence_0.vols").write_bytes(b"".join(body(12)))
    pictures = [np.full((64, 64, 3), [40 * i, 100, 250 - 40 * i], np.uint8) for i in range(6)]
    write_video(folder / "texture_512_h264.mp4", [picture[::2, ::2] for picture in pictures])
    write_video(folder / "texture_1024_h264.mp4", pictures)
    capture = open_capture(folder, fps=30)
    for i in (5, 0, 3):
        pixels = capture.read(i).textures[0].pixels()
        assert pixels.shape == (64, 64, 3) and np.abs(pixels.astype(int) - pictures[i]).max() <= 8
    assert len({frame.sha256 for frame in capture.frames}) == 6


def test_a_file_that_is_cut_off_keeps_the_frames_before_and_names_the_byte(tmp_path):
    frames = body(13)
    whole = vols_header(13, 6) + b"".join(frames)
    (tmp_path / "take.vols").write_bytes(whole[:-10])
    capture = open_capture(tmp_path)
    assert [frame.number for frame in capture.frames] == [0, 1, 2, 3, 4] and capture.faults[0].number == 5
    assert f"byte {len(whole) - 10}" in capture.faults[0].fault
    for end in (*range(60), 44 + len(frames[0]) - 1):
        (tmp_path / "take.vols").write_bytes(whole[:end])
        with pytest.raises(FrameError, match="byte"):
            open_vols(tmp_path / "take.vols")


@pytest.mark.parametrize(
    "at, form, value, fault",
    [
        (0, "4s", b"PNG ", "byte 0: expected VOLS, found"),
        (4, "I", 14, "byte 4: expected version 10 to 13, found 14"),
        (40, "I", 1 << 31, "byte 40: expected where the frames begin"),
        (44, "i", -1, "byte 44: expected a frame number, found -1"),
        (48, "i", 7, "expected the frame's size 7 again"),
        (52, "B", 3, "byte 52: expected 0, 1 or 2"),
        (52, "B", 0, "byte 52: expected a key frame before"),
        (53, "i", 2**31 - 1, "byte 53: expected the size of the vertices, a multiple of 12"),
        (
            53,
            "i",
            2147483640,
            "byte 53: the vertices of frame 0 should take 2147483640 bytes, but the file ends at byte",
        ),
        (53, "i", -12, "byte 53: expected the size of the vertices"),
    ],
)
def test_a_lying_header_names_the_byte_and_what_was_expected(tmp_path, at, form, value, fault):
    data = bytearray(vols_header(13, 6) + b"".join(body(13)))
    struct.pack_into("<" + form, data, at, value)
    (tmp_path / "take.vols").write_bytes(data)
    with pytest.raises(FrameError, match=fault):
        open_vols(tmp_path / "take.vols")


def test_a_promise_of_billions_of_frames_is_a_fault_behind_the_real_ones(tmp_path):
    (tmp_path / "take.vols").write_bytes(vols_header(13, 2**31 - 1) + b"".join(body(13)))
    vols = open_vols(tmp_path / "take.vols")
    assert len(vols.frames) == 6 and "after 6 of the 2147483647 frames" in vols.fault.fault


def test_an_index_out_of_range_names_its_byte(tmp_path):
    faces = BODY_FACES.copy()
    faces[2, 2] = 60000
    data = vols_header(13, 1) + vols_frame(13, 0, moved_body(0), kind=1, faces=faces)
    (tmp_path / "take.vols").write_bytes(data)
    at = data.index(struct.pack("<H", 60000))
    with pytest.raises(FrameError, match=f"byte {at}: expected an index below .*, found 60000"):
        read_vols(tmp_path / "take.vols", tmp_path, 0)
