import numpy as np
import pytest
from broken_captures import BODY_FACES, BODY_UV
from sequence_samples import Packer, moved_body, write_video

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.hcap_reader import open_hcap, read_hcap
from unstructured_mg.capture.reader import open_capture

KEYS = (0, 4)
NAME = "HCAP_holovideo"


def ranged(packer, values, most, kind):
    """Values between their own ends as integers, with the ends in the accessor; and what they come back as."""
    low, high = values.min(0), values.max(0) + 1e-3
    whole = np.rint((values - low) / (high - low) * most)
    ends = {"decodeMin": low.tolist(), "decodeMax": high.tolist()}
    return packer.add(whole, kind, extensions={NAME: ends}), low + whole * (high - low) / most


def write_take(folder, frames=7):
    """An encoder by the description: it predicts from what the decoder will have. The decoded frames."""
    packer, meshes, decoded = Packer(), [], []
    rng = np.random.default_rng(0)
    for i in range(frames):
        wanted = moved_body(i * i) + rng.normal(size=moved_body(0).shape) * 0.002
        if i in KEYS:
            position, vertices = ranged(packer, wanted, 65535, "u2")
            uv = packer.add(np.rint((BODY_UV * [1, -1] + [0, 1]) * 65535), "u2", normalized=True)
            attributes = {"POSITION": position, "TEXCOORD_0": uv}
            own = {"attributes": attributes, "indices": packer.add(BODY_FACES.ravel(), "u2")}
            decoded.append([vertices])
        else:
            run = decoded[-1]
            guess = run[-1] + (run[-1] - run[-2] if len(run) > 1 else 0)
            delta, steps = ranged(packer, wanted - guess, 255, "u1")
            own = {"attributes": {"_DELTA": delta}}
            run.append(guess + steps)
        meshes.append({"primitives": [{"attributes": {}, "extensions": {NAME: own}}]})
    extension = {"framerate": 25, "keyframes": list(KEYS), "timeline": [{"image": 0}]}
    data = {
        "meshes": meshes,
        "images": [{"uri": "take.mp4"}],
        "extensions": {NAME: extension},
        "extensionsUsed": [NAME],
    }
    (folder / "take.glb").write_bytes(packer.glb(data))
    return [vertices for run in decoded for vertices in run]


def test_any_frame_from_its_key_frame_on(tmp_path, monkeypatch):
    monkeypatch.setenv("UMG_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "take"
    folder.mkdir()
    expected = write_take(folder)
    pictures = [np.full((32, 32, 3), [30 * i, 90, 200], np.uint8) for i in range(7)]
    write_video(folder / "take.mp4", pictures)
    assert open_hcap(folder / "take.glb", folder).keys == (0, 0, 0, 0, 4, 4, 4)
    for part in (6, 0, 3, 5):
        raw = read_hcap(folder / "take.glb", folder, part)
        np.testing.assert_allclose(raw.vertices, expected[part], atol=1e-12)
        np.testing.assert_array_equal(raw.faces, BODY_FACES)
        np.testing.assert_allclose(raw.uv[raw.face_uv], BODY_UV[BODY_FACES], atol=1e-5)
    capture = open_capture(folder)
    assert len(capture) == 7 and capture.fps == 25
    for i in (5, 2):
        assert np.abs(capture.read(i).textures[0].pixels().astype(int) - pictures[i]).max() <= 8


def test_a_missing_video_is_named(tmp_path):
    write_take(tmp_path)
    with pytest.raises(FrameError, match='its video "take.mp4" is not there'):
        open_hcap(tmp_path / "take.glb", tmp_path)
