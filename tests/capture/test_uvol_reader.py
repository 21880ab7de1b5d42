import io
import json
import os
import tarfile
from pathlib import Path

import DracoPy
import numpy as np
import pytest
import trimesh
from broken_captures import BODY_FACES, BODY_UV
from PIL import Image
from real_captures import real_capture
from scipy.spatial import cKDTree
from sequence_samples import ETC1S_VIDEO, UASTC_ARRAY, layer_picture, moved_body

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.reader import open_capture
from unstructured_mg.capture.uvol_reader import read_uvol
from unstructured_mg.errors import UserError


def texture_target(kind, resolution):
    numbers = {"sequenceSize": 3, "sequenceCount": 2, "frameRate": 30}
    return {"format": "ktx2", "resolution": resolution, "type": kind, **numbers}


MANIFEST = {
    "version": "v2",
    "geometry": {
        "targets": {
            "low": {"format": "draco", "frameRate": 15, "frameCount": 3},
            "high": {"format": "draco", "frameRate": 30, "frameCount": 6},
            "other": {"format": "uniform-solve", "frameRate": 60, "frameCount": 12},
        },
        "path": "geometry_[target]/[#####][ext]",
    },
    "texture": {
        "targets": {
            "small": texture_target("baseColor", [8, 4]),
            "etc": texture_target("baseColor", [16, 8]),
            "normals": texture_target("normal", [64, 64]),
        },
        "path": "texture_[target]_[type]/[###][ext]",
    },
}


def write_capture(folder, manifest=MANIFEST):
    """Six Draco frames and two KTX2 files of three layers. uvs are written as UVOL has them: v downwards."""
    for name in ("geometry_high", "texture_etc_baseColor"):
        (folder / name).mkdir(parents=True)
    for i in range(6):
        data = DracoPy.encode(moved_body(i), BODY_FACES, quantization_bits=14, tex_coord=BODY_UV * [1, -1] + [0, 1])
        (folder / "geometry_high" / f"{i:05d}.drc").write_bytes(data)
    for i in range(2):
        (folder / "texture_etc_baseColor" / f"{i:03d}.ktx2").write_bytes(ETC1S_VIDEO)
    (folder / "take.json").write_text(json.dumps(manifest))
    return folder


def test_the_finest_targets_are_read_layers_in_order_and_v_turned_upwards(tmp_path):
    capture = open_capture(write_capture(tmp_path))
    assert len(capture) == 6 and capture.fps == 30 and not capture.faults and capture.clips == (".",)
    for i in (4, 1, 5):
        mesh = capture.read(i)
        expected = trimesh.Trimesh(moved_body(i), BODY_FACES, process=False)
        found = trimesh.Trimesh(mesh.vertices[:, [0, 2, 1]] * [1, 1, -1], mesh.faces, process=False)
        assert abs(found.volume / expected.volume - 1) < 1e-3
        np.testing.assert_allclose(found.bounds + [0, 0.0, 0], expected.bounds - [0, capture.floor, 0], atol=2e-3)
        # BODY_UV is a plain function of the place: v has not been left upside down
        place = mesh.vertices[:, [0, 2]] + [-0.01 * i, capture.floor]
        mean = np.array([mesh.uv[mesh.face_uv].mean(axis=1), place[mesh.faces].mean(axis=1) / 2.5 + 0.2])
        np.testing.assert_allclose(mean[0], mean[1], atol=4e-3)
        pixels = mesh.textures[0].pixels().astype(int)
        assert np.abs(pixels - layer_picture(i % 3)).max() <= 20
        with Image.open(io.BytesIO(mesh.textures[0].read_bytes())) as image:
            np.testing.assert_array_equal(np.asarray(image), pixels)
    assert len({frame.sha256 for frame in capture.frames}) == 6


def test_the_repositorys_own_schema_with_base_color_and_a_picture_a_file(tmp_path):
    manifest = json.loads(json.dumps(MANIFEST))
    target = {
        "format": "ktx2",
        "frameRate": 15,
        "frameCount": 3,
        "settings": {"resolution": {"width": 16, "height": 8}},
    }
    manifest["texture"] = {"baseColor": {"targets": {"etc": target}}, "path": "texture_etc_[type]/[###][ext]"}
    folder = write_capture(tmp_path, manifest)
    pictures = [UASTC_ARRAY, ETC1S_VIDEO, UASTC_ARRAY]
    for i, data in enumerate(pictures):
        (folder / "texture_etc_baseColor" / f"{i:03d}.ktx2").write_bytes(data)
    names = [read_uvol(folder / "take.json", folder, part).images[0].path.name for part in range(6)]
    assert names == [f"{i:03d}.ktx2" for i in (0, 0, 1, 2, 2, 2)]


SOLVED = {"a": {"format": "uniform-solve", "frameRate": 1, "frameCount": 1}}


@pytest.mark.parametrize(
    "change, fault",
    [
        (lambda m, g: m.update(version="v3"), "expected version \"v2\", found 'v3'"),
        (lambda m, g: g.pop("path"), "expected geometry with targets and a path"),
        (lambda m, g: g.update(path="geometry.drc"), r"expected \[####\] in the path"),
        (lambda m, g: g["targets"]["high"].update(frameCount=1e12), "expected a number above 0 and at most 1.04858e"),
        (lambda m, g: g["targets"]["high"].update(frameRate="fast"), 'frameRate of "high", found'),
        (lambda m, g: g.update(targets=SOLVED), "its geometry is uniform-solve"),
        (lambda m, g: g.update(path="../[##][ext]"), "leads outside the capture folder"),
    ],
)
def test_manifests_that_cannot_be_read_say_why(tmp_path, change, fault):
    manifest = json.loads(json.dumps(MANIFEST))
    change(manifest, manifest["geometry"])
    folder = write_capture(tmp_path / "take", manifest)
    with pytest.raises(FrameError, match=fault):
        read_uvol(folder / "take.json", folder, 0)
    with pytest.raises(UserError, match="take.json"):
        open_capture(folder)


def test_uvol_1_is_refused_by_name(tmp_path):
    (tmp_path / "old.manifest").write_text('{"maxVertices": 10, "maxTriangles": 20, "frameData": [], "frameRate": 30}')
    with pytest.raises(UserError, match=r"old.manifest, it is UVOL 1 \(Corto\), which is not supported; convert it"):
        open_capture(tmp_path)


def test_a_missing_frame_and_a_damaged_one_are_faults(tmp_path):
    folder = write_capture(tmp_path)
    (folder / "geometry_high" / "00002.drc").unlink()
    path = folder / "geometry_high" / "00004.drc"
    path.write_bytes(path.read_bytes()[:200])
    capture = open_capture(folder)
    assert [frame.number for frame in capture.frames] == [0, 1, 3, 5]
    assert 'its geometry "geometry_high/00002.drc" is not there' in capture.faults[0].fault
    assert "bytes 0 to 200: expected a Draco mesh" in capture.faults[1].fault


def test_a_real_capture_reads_as_it_was_unpacked(tmp_path):
    """The archive's own files behind a manifest (liam: Draco in millimetres, five ETC1S layers a file)."""
    unpacked = open_capture(real_capture("liam", "0:4"))
    with tarfile.open(Path(os.environ["UMG_CAPTURES"]) / "archives" / "liam.tar") as tar:
        for member in tar:
            stem, _, ending = Path(member.name).name.partition(".")
            if member.isfile() and stem.isdigit() and int(stem) < {"drc": 4, "ktx2": 1}.get(ending, 0):
                tar.extract(member, tmp_path, filter="data")
    shape = {"format": "draco", "frameRate": 30, "frameCount": 4, "scale": 0.001}
    picture = {"format": "ktx2", "frameRate": 30, "sequenceSize": 5, "sequenceCount": 1}
    manifest = {
        "version": "v2",
        "geometry": {"targets": {"fine": shape}, "path": "geometry/[#####][ext]"},
        "texture": {"targets": {"fine": picture}, "path": "texture/[#####][ext]"},
    }
    (tmp_path / "liam" / "liam.json").write_text(json.dumps(manifest))
    capture = open_capture(tmp_path / "liam", unit=1.0, floor=unpacked.floor)
    assert len(capture) == 4 and not capture.faults
    for i in (3, 1):
        ours, theirs = capture.read(i), unpacked.read(i)
        found, wanted = (
            np.concatenate([m.vertices[m.faces].mean(axis=1), m.uv[m.face_uv].mean(axis=1)], axis=1)
            for m in (ours, theirs)
        )
        # the archive's unpacker joins vertices 1e-5 m apart, so that it has a few flat faces fewer
        assert len(wanted) > 0.97 * len(found)
        assert cKDTree(found).query(wanted)[0].max() < 5e-5
        difference = ours.textures[0].pixels().astype(int) - theirs.textures[0].pixels()
        assert np.abs(difference).mean() < 2  # theirs went through JPEG
