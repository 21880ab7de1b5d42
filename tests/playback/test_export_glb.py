import re

import numpy as np
import pytest
import trimesh
from export_frames import FACE_UV, FACES, UV, VERTICES, decoded, export_frame, picture, write
from gltf_player import GltfPlayer
from outside_readers import gltf_report

from unstructured_mg.errors import UserError
from unstructured_mg.playback import export_glb, glb_file
from unstructured_mg.playback.export_glb import GLB

PLAIN = {"uv": np.zeros((0, 2)), "face_uv": np.zeros((0, 3), np.int32), "textures": ()}

COLORS = np.array([[0, 0, 0], [255, 128, 3], [9, 9, 9], [60, 70, 80]], np.uint8)


def turned(angle, x):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s, x], [0, 1, 0, 0], [-s, 0, c, 2 * x], [0, 0, 0, 1]])


def played(folder, frames, fps=30.0):
    assert write(GLB, folder, frames, fps=fps) == ["walk.glb"] * len(frames)
    return GltfPlayer(folder / "walk.glb")


def assert_plays(player, frames, fps=30.0):
    """In the middle of every frame's time exactly that frame is shown, where it belongs."""
    for frame in frames:
        shown = player.shown((frame.number + 0.5) / fps)
        assert len(shown) == max(1, len(frame.textures))
        corners = np.concatenate([each.vertices[each.faces] for each in shown])
        np.testing.assert_allclose(corners, frame.vertices()[frame.faces], atol=2e-6)
        for each, texture in zip(shown, frame.textures, strict=False):
            np.testing.assert_array_equal(each.picture, decoded(texture))
        if frame.textures:
            uv = np.concatenate([each.uv[each.faces] for each in shown])
            np.testing.assert_allclose(uv * [1, -1] + [0, 1], frame.uv[frame.face_uv], atol=1e-7)


def assert_valid(folder):
    report = gltf_report(folder / "walk.glb")
    assert report["issues"]["numErrors"] == report["issues"]["numWarnings"] == 0, report["issues"]["messages"]
    return report["info"]


def test_every_frame_is_shown_at_its_time_in_its_place(tmp_path):
    frames = [export_frame(i, world=turned(0.3 * i, 0.5 * i)) for i in range(5)]
    assert_plays(played(tmp_path, frames, 12.5), frames, 12.5)
    info = assert_valid(tmp_path)
    assert info["animationCount"] == 1 and info["materialCount"] == 5


def test_trimesh_reads_what_was_written(tmp_path):
    played(tmp_path, [export_frame(0, (picture((10, 200, 30), ".jpg"),))])
    (mesh,) = trimesh.load(tmp_path / "walk.glb", process=False).geometry.values()
    np.testing.assert_allclose(mesh.triangles, VERTICES[FACES], atol=1e-7)
    np.testing.assert_allclose(mesh.visual.uv[mesh.faces], UV[FACE_UV], atol=1e-7)
    expected = decoded(picture((10, 200, 30), ".jpg"))
    np.testing.assert_array_equal(np.asarray(mesh.visual.material.baseColorTexture), expected)


def test_what_comes_again_is_stored_once_and_moved(tmp_path):
    """Frames 0 1 0 1 0 0: the second time elsewhere, with the last one held."""
    order = [0, 1, 0, 1, 0, 0]
    frames = [
        export_frame(
            n, key=(k,), own_vertices=VERTICES + k, world=turned(0.5 * min(n, 4), n // 2), textures=(picture(50 * k),)
        )  # fmt: skip
        for n, k in enumerate(order)
    ]
    player = played(tmp_path, frames)
    assert_plays(player, frames)
    assert len(player.gltf["meshes"]) == len(player.gltf["images"]) == 2
    assert_valid(tmp_path)


def test_in_a_transition_meshes_share_what_does_not_change(tmp_path):
    frames = [export_frame(i) for i in range(4)]
    player = played(tmp_path, frames)
    primitives = [mesh["primitives"][0] for mesh in player.gltf["meshes"]]
    assert len({each["indices"] for each in primitives}) == 1
    assert len({each["attributes"]["TEXCOORD_0"] for each in primitives}) == 1
    assert len({each["attributes"]["POSITION"] for each in primitives}) == 4


@pytest.mark.parametrize("most", [64, 3])
@pytest.mark.parametrize("changed", [PLAIN, {"textures": (picture(7),)}, {**PLAIN, "colors": COLORS}])
def test_where_the_picture_stays_frames_are_morph_targets(tmp_path, monkeypatch, changed, most):
    monkeypatch.setattr(export_glb, "MOST_SHAPES", most)
    order = [0, 1, 2, 3, 4, 3, 2, 2]
    frames = [export_frame(n, key=(k,), own_vertices=VERTICES * (1 + 0.1 * k), world=turned(0.1 * n, n), **changed)
              for n, k in enumerate(order)]  # fmt: skip
    player = played(tmp_path, frames)
    assert_plays(player, frames)
    shapes = [1 + len(mesh["primitives"][0].get("targets", [])) for mesh in player.gltf["meshes"]]
    assert shapes == ([5] if most == 64 else [3, 2])
    assert_valid(tmp_path)


def test_colours_are_stored_as_light(tmp_path):
    colors = np.array([[0, 10, 11], [255, 128, 3], [9, 188, 9], [60, 70, 80]], np.uint8)
    player = played(tmp_path, [export_frame(0, **PLAIN, colors=colors)])
    found = player.shown(0)[0].colors
    back = np.where(found <= 0.0031308, found * 12.92, 1.055 * found ** (1 / 2.4) - 0.055)
    np.testing.assert_allclose(back[:, :3] * 255, colors, atol=0.05)
    assert (found[:, 3] == 1).all()


def test_materials_are_primitives_and_other_pictures_become_png(tmp_path):
    two = (picture((1, 2, 3), ".jpg"), picture((40, 50, 60), ".bmp"))
    frames = [export_frame(0, two, face_material=np.array([1, 0], np.int32)), export_frame(1, two, face_material=None)]
    frames[1] = export_frame(1, two[:1])
    player = played(tmp_path, frames)
    shown = player.shown(0)
    np.testing.assert_allclose(shown[0].vertices[shown[0].faces], VERTICES[FACES[1:]], atol=1e-7)
    np.testing.assert_array_equal(shown[1].picture, decoded(two[1]))
    assert {image["mimeType"] for image in player.gltf["images"]} == {"image/jpeg", "image/png"}
    assert_valid(tmp_path)


def test_large_meshes_have_wide_indices(tmp_path):
    n = 70000
    vertices = np.random.default_rng(0).random((n, 3))
    faces = np.arange(n - 1)[:, None][: n - 3] + np.arange(3)
    frame = export_frame(0, **PLAIN, own_vertices=vertices, faces=faces.astype(np.int32))
    assert_plays(played(tmp_path, [frame]), [frame])


def test_an_export_too_large_for_a_glb_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setattr(glb_file, "MOST_BYTES", 1000)
    with pytest.raises(UserError, match="walk.glb: the export has more than 4 GB.*--decimate"):
        write(GLB, tmp_path, [export_frame(i) for i in range(20)])


def test_all_that_is_written_counts_as_an_export(tmp_path):
    played(tmp_path, [export_frame(0)])
    assert [bool(re.fullmatch(GLB.files, path.name)) for path in tmp_path.iterdir()] == [True]
