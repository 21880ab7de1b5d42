import re

import numpy as np
import trimesh
from export_frames import FACE_UV, FACES, UV, VERTICES, export_frame, picture, write
from PIL import Image

from unstructured_mg.playback.export_obj import OBJ

TURN = np.array([[0.0, 0, 1, 3], [0, 1, 0, 0], [-1, 0, 0, 4], [0, 0, 0, 1]])


def test_trimesh_reads_what_was_written(tmp_path):
    texture = picture((30, 140, 60), ".jpg")
    files = write(OBJ, tmp_path, [export_frame(0, (texture,)), export_frame(1, (texture,), world=TURN)])
    assert files == ["frame_00001.obj", "frame_00002.obj"]
    for name, place in zip(files, (VERTICES, (VERTICES + [0, 0, 0.5]) @ TURN[:3, :3].T + TURN[:3, 3]), strict=True):
        mesh = trimesh.load(tmp_path / name, process=False)
        np.testing.assert_allclose(mesh.triangles, place[FACES], atol=1e-7)
        np.testing.assert_allclose(mesh.visual.uv[mesh.faces], UV[FACE_UV], atol=1e-7)
        with Image.open(tmp_path / name.replace("obj", "jpg")) as image:
            assert np.array_equal(np.asarray(mesh.visual.material.image), np.asarray(image))


def test_frames_of_several_materials_keep_every_picture(tmp_path):
    textures = (picture((1, 2, 3), ".jpg"), picture((4, 5, 6)))
    write(OBJ, tmp_path, [export_frame(0, textures, face_material=np.array([0, 1], np.int32))])
    assert (tmp_path / "frame_00001_1.jpg").read_bytes() == textures[0].data
    assert (tmp_path / "frame_00001_2.png").read_bytes() == textures[1].data
    named = re.findall("map_Kd (.*)", (tmp_path / "frame_00001.mtl").read_text())
    assert named == ["frame_00001_1.jpg", "frame_00001_2.png"]
    kinds = re.findall("^(usemtl|f) ", (tmp_path / "frame_00001.obj").read_text(), re.M)
    assert kinds == ["usemtl", "f", "usemtl", "f"]


def test_all_that_is_written_counts_as_an_export(tmp_path):
    write(OBJ, tmp_path, [export_frame(0, (picture(0), picture(1)), face_material=np.array([0, 1]))], first_number=5)
    assert all(re.fullmatch(OBJ.files, path.name) for path in tmp_path.iterdir())
