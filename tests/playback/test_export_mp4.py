import json
import re
import subprocess
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from memory_capture import box, memory_capture
from outside_readers import program

from unstructured_mg.errors import UserError
from unstructured_mg.playback import export_mp4
from unstructured_mg.playback.export import export_walk, find_format
from unstructured_mg.playback.export_mp4 import MP4
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.walk import capture_walk

FRAMES = 9
CAPTURE = memory_capture([("", i + 1) for i in range(FRAMES)],
                         [box((200, 30 * i, 60), at=(0.1 * i, 0, 0)) for i in range(FRAMES)])  # fmt: skip


def exported(folder, executor=None, **options):
    export_walk(capture_walk(CAPTURE), CAPTURE, None, folder, ExportOptions(format="mp4", **options), executor=executor)
    return folder / "walk.mp4"


def decoded(path, width, height):
    done = subprocess.run([program("ffmpeg"), "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"],
                          capture_output=True, check=True)  # fmt: skip
    return np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)


@pytest.mark.parametrize("camera", ["fixed", "orbit"])
def test_ffprobe_reads_what_was_written(tmp_path, monkeypatch, camera):
    drawn, original = [], export_mp4.render

    def render(*arguments, **options):
        drawn.append(original(*arguments, **options))
        return drawn[-1]

    monkeypatch.setattr(export_mp4, "render", render)
    path = exported(tmp_path / "out", camera=camera, picture_height=151, fps=24.0)
    command = [program("ffprobe"), "-v", "error", "-count_frames", "-show_streams", "-of", "json", path]
    (stream,) = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)["streams"]
    shown = json.loads((tmp_path / "out" / "walk.json").read_text())["frames"]
    assert len(shown) == len(drawn) == int(stream["nb_read_frames"]) == 8  # 9 frames at 30
    assert (stream["codec_name"], stream["pix_fmt"], stream["color_space"]) == ("h264", "yuv420p", "bt709")
    assert stream["avg_frame_rate"] == "24/1" and float(stream["duration"]) == pytest.approx(8 / 24)
    assert stream["height"] == 150 and stream["width"] % 2 == 0
    pictures = decoded(path, stream["width"], 150)
    for picture, frame in zip(pictures, drawn, strict=True):
        off = picture.astype(float) - frame.image
        # Colours are right inside and around the box; along its edges 4:2:0 blurs them.
        for part in (frame.coverage == 255, frame.coverage == 0):
            assert np.abs(np.median(off[part], axis=0)).max() <= 3
            assert np.quantile(np.abs(off[part]).max(axis=1), 0.8) <= 8


def test_the_same_walk_gives_the_same_bytes(tmp_path):
    with ThreadPoolExecutor(2) as executor:
        first = exported(tmp_path / "a", executor, picture_height=100).read_bytes()
    assert first == exported(tmp_path / "b", picture_height=100).read_bytes()
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["walk.json", "walk.mp4"]
    assert re.fullmatch(MP4.files, "walk.mp4")


def test_without_ffmpeg_it_says_what_to_install(monkeypatch):
    monkeypatch.setattr(export_mp4, "find_ffmpeg", lambda: None)
    with pytest.raises(UserError, match=re.escape("pip install 'unstructured_mg[video]'")):
        find_format(ExportOptions(format="mp4"))


def test_an_ffmpeg_that_fails_leaves_nothing_and_says_why(tmp_path, monkeypatch):
    broken = tmp_path / "ffmpeg"
    broken.write_text("#!/bin/sh\necho no such encoder >&2\nexit 3\n")
    broken.chmod(0o755)
    monkeypatch.setattr(export_mp4, "find_ffmpeg", lambda: str(broken))
    with pytest.raises(UserError, match=r"walk.mp4: ffmpeg could not encode it \(no such encoder\)"):
        exported(tmp_path / "out", picture_height=500)
    assert [path.name for path in tmp_path.iterdir()] == ["ffmpeg"]


@pytest.mark.parametrize("name", ["up", "unit", "first_number"])
def test_what_means_nothing_to_a_video_is_refused(name):
    value = {"up": "z", "unit": 1.0, "first_number": 5}[name]
    with pytest.raises(UserError, match=f"--{name.replace('_', '-')}: the format mp4 has no use for it"):
        find_format(ExportOptions(format="mp4", **{name: value}))
    with pytest.raises(UserError, match="--camera: the format obj has no use for it .it is no video."):
        find_format(ExportOptions(camera="orbit"))
