import json
import re

import numpy as np
import pytest
import trimesh
from export_frames import FACE_UV, FACES, UV, VERTICES, decoded, export_frame, picture, write
from PIL import Image

from unstructured_mg.capture.ply_reader import read_ply
from unstructured_mg.errors import UserError
from unstructured_mg.playback.export_ply import PLY, UNITY

TURN = np.array([[0.0, 0, 1, 3], [0, 1, 0, 0], [-1, 0, 0, 4], [0, 0, 0, 1]])
PLAIN = {"uv": np.zeros((0, 2)), "face_uv": np.zeros((0, 3), np.int32), "textures": ()}


def test_trimesh_and_our_reader_read_what_was_written(tmp_path):
    texture = picture((30, 140, 60), ".jpg")
    (name,) = write(PLY, tmp_path, [export_frame(0, (texture,), world=TURN)], first_number=7)
    place = (VERTICES @ TURN[:3, :3].T + TURN[:3, 3])[FACES]
    mesh = trimesh.load(tmp_path / name, process=False)
    np.testing.assert_allclose(mesh.triangles, place, atol=1e-6)
    np.testing.assert_allclose(mesh.visual.uv[mesh.faces], UV[FACE_UV], atol=1e-7)
    np.testing.assert_array_equal(np.asarray(mesh.visual.material.image), decoded(texture))
    raw = read_ply(tmp_path / name, tmp_path)
    np.testing.assert_allclose(raw.vertices[raw.faces], place, atol=1e-6)
    np.testing.assert_allclose(raw.uv[raw.face_uv], UV[FACE_UV], atol=1e-7)
    assert (name, raw.files[-1]) == ("frame_00007.ply", tmp_path / "frame_00007.jpg")


def test_colours_are_kept(tmp_path):
    colors = np.array([[0, 10, 11], [255, 128, 3], [9, 188, 9], [60, 70, 80]], np.uint8)
    (name,) = write(PLY, tmp_path, [export_frame(0, **PLAIN, colors=colors)])
    mesh = trimesh.load(tmp_path / name, process=False)
    np.testing.assert_array_equal(mesh.visual.vertex_colors[:, :3], colors)
    np.testing.assert_allclose(mesh.vertices, VERTICES, atol=1e-7)


def unity_frame(folder, told, index):
    """The bytes of a frame as the player takes them: no header is parsed, sizes are sequence.json's."""
    data = (folder / f"frame_{index + 1:05d}.ply").read_bytes()[told["headerSizes"][index] :]
    vertices, indices = told["verticeCounts"][index], told["indiceCounts"][index]
    stride = 5 if told["hasUVs"] else 3
    rows = np.frombuffer(data, "<f4", vertices * stride).reshape(-1, stride)
    lines = np.frombuffer(data[vertices * stride * 4 :], np.uint8).reshape(indices // 3, 13)
    assert (lines[:, 0] == 3).all()
    return rows, np.ascontiguousarray(lines[:, 1:]).view("<u4")


def test_unity_finds_what_its_sequence_json_says(tmp_path):
    y, x = np.mgrid[:8, :16]
    pixels = np.repeat((8 * x + 100 * (y // 4))[..., None], 3, axis=2).astype(np.uint8)
    frames = [export_frame(0, (picture(pixels),)), export_frame(1, (picture(pixels),), world=TURN, faces=FACES[:1],
                                                                face_uv=FACE_UV[:1])]  # fmt: skip
    assert write(UNITY, tmp_path, frames) == ["frame_00001.ply", "frame_00002.ply"]
    told = json.loads((tmp_path / "sequence.json").read_text())
    assert (told["geometryType"], told["textureMode"], told["DDS"], told["ASTC"]) == (2, 2, True, False)
    assert (told["maxVertexCount"], told["maxIndiceCount"]) == (6, 6)
    corners = []
    for frame in frames:
        rows, faces = unity_frame(tmp_path, told, frame.number)
        expected = frame.vertices()[frame.faces] * [-1, 1, 1]
        np.testing.assert_allclose(rows[faces][..., :3], expected, atol=1e-6)
        np.testing.assert_allclose(rows[faces][..., 3:], frame.uv[frame.face_uv], atol=1e-7)
        corners.append(expected.reshape(-1, 3))
        # What anybody else makes of the same file.
        mesh = trimesh.load(tmp_path / f"frame_{frame.number + 1:05d}.ply", process=False)
        np.testing.assert_allclose(mesh.triangles, expected, atol=1e-6)
        path = tmp_path / f"frame_{frame.number + 1:05d}.dds"
        assert path.stat().st_size == 128 + told["textureSizeDDS"]
        with Image.open(path) as image:
            assert image.size == (told["textureWidth"], told["textureHeight"]) == (16, 8)
            assert np.abs(np.asarray(image.convert("RGB")).astype(int) - pixels).max() <= 12  # a block has four colours
    low, high = np.concatenate(corners).min(axis=0), np.concatenate(corners).max(axis=0)
    np.testing.assert_allclose(list(told["boundsCenter"].values()), (low + high) / 2, atol=1e-7)
    np.testing.assert_allclose(list(told["boundsSize"].values()), high - low, atol=1e-7)


def test_unity_gets_plain_meshes_too(tmp_path):
    write(UNITY, tmp_path, [export_frame(0, **PLAIN)])
    told = json.loads((tmp_path / "sequence.json").read_text())
    assert (told["geometryType"], told["textureMode"], told["hasUVs"]) == (1, 0, False)
    rows, faces = unity_frame(tmp_path, told, 0)
    np.testing.assert_allclose(rows[faces], VERTICES[FACES] * [-1, 1, 1], atol=1e-7)


def test_what_these_formats_cannot_hold_is_refused(tmp_path):
    two = export_frame(0, (picture(1), picture(2)), face_material=np.array([0, 1], np.int32))
    for form in (PLY, UNITY):
        with pytest.raises(UserError, match="frame_00001.ply: PLY holds one texture, and this frame has 2"):
            write(form, tmp_path, [two])
    with pytest.raises(UserError, match="textures of one size only, and there are 4 x 4 and 8 x 16"):
        write(UNITY, tmp_path, [export_frame(0), export_frame(1, (picture(3, size=(16, 8)),))])


def test_all_that_is_written_counts_as_an_export(tmp_path):
    for form in (PLY, UNITY):
        (tmp_path / form.name).mkdir()
        write(form, tmp_path / form.name, [export_frame(0)])
        assert all(re.fullmatch(form.files, path.name) for path in (tmp_path / form.name).iterdir())
