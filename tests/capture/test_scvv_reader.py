import json

import DracoPy
import numpy as np
import pytest
from broken_captures import BODY_FACES, BODY_UV
from PIL import Image
from sequence_samples import moved_body

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.reader import open_capture
from unstructured_mg.capture.scvv_reader import read_scvv
from unstructured_mg.errors import UserError


def write_capture(folder, numbers=(191, 192, 193)):
    frames = []
    for i, number in enumerate(numbers):
        data = DracoPy.encode(moved_body(i), BODY_FACES, quantization_bits=14, tex_coord=BODY_UV)
        (folder / f"{number:06d}_raw_frame.draco").write_bytes(data)
        Image.new("RGB", (16, 8), (50 * i, 100, 50)).save(folder / f"{number:06d}_raw_frame.jpg", quality=95)
        stem = f"{number:06d}_raw_frame"
        frames.append({"texture_path": stem + ".jpg", "mesh_path": stem + ".draco", "delay_us": 66128 if i else 0})
    manifest = {"preview_img": "p.png", "frames": frames, "average_fps": "15", "audio_us_offset": 3}
    (folder / "scvv_animation.json").write_text(json.dumps(manifest))
    return folder


def test_a_folder_is_a_capture_in_the_manifests_order_and_rate(tmp_path):
    capture = open_capture(write_capture(tmp_path))
    assert [frame.number for frame in capture.frames] == [0, 1, 2] and capture.fps == 15 and not capture.faults
    for i in (2, 0):
        raw = read_scvv(tmp_path / "scvv_animation.json", tmp_path, i)
        np.testing.assert_allclose(raw.vertices.max(axis=0), moved_body(i).max(axis=0), atol=1e-3)
        mean = raw.uv[raw.face_uv].mean(axis=1)
        place = (raw.vertices - [0.01 * i, 0, 0])[:, :2] / 2.5 + 0.2
        np.testing.assert_allclose(mean, place[raw.faces].mean(axis=1), atol=4e-3)
        assert np.abs(capture.read(i).textures[0].pixels().astype(int) - [50 * i, 100, 50]).max() <= 3


def test_broken_manifests_and_files_say_why(tmp_path):
    write_capture(tmp_path)
    path = tmp_path / "scvv_animation.json"
    manifest = json.loads(path.read_text())
    (tmp_path / manifest["frames"][1]["mesh_path"]).write_bytes(b"DRACO\2\2\1\1\0\0")
    manifest["frames"][2]["texture_path"] = "lost.jpg"
    path.write_text(json.dumps(manifest))
    faults = [fault.fault for fault in open_capture(tmp_path).faults]
    assert (
        faults[0].startswith("bytes 0 to 11: expected a Draco mesh")
        and faults[1] == 'its texture "lost.jpg" is not there'
    )
    manifest["frames"][1] = {"delay_us": 3}
    path.write_text(json.dumps(manifest))
    with pytest.raises(FrameError, match=r"frames\[1\]: expected mesh_path and texture_path"):
        read_scvv(path, tmp_path, 0)
    with pytest.raises(UserError, match=r"frames\[1\]"):
        open_capture(tmp_path)
