import numpy as np
import pytest
from sequence_samples import write_video

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.image import read_image
from unstructured_mg.capture.video import unpacked_folder, video_picture


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("UMG_CACHE", str(tmp_path / "cache"))


def test_each_picture_in_its_place_and_unpacked_once(tmp_path):
    pictures = [np.full((32, 48, 3), [20 * i, 120, 250 - 20 * i], np.uint8) for i in range(9)]
    path = write_video(tmp_path / "a.mp4", pictures, fps=25)
    for i in (8, 0, 5):
        assert np.abs(read_image(video_picture(path, i)).astype(int) - pictures[i]).max() <= 8
    (folder,) = unpacked_folder().iterdir()
    assert len(list(folder.iterdir())) == 9
    mark = folder / "000001.jpg"
    mark.write_bytes(b"found again")
    copied = tmp_path / "renamed.mp4"
    copied.write_bytes(path.read_bytes())
    assert video_picture(copied, 0).read_bytes() == b"found again"
    with pytest.raises(FrameError, match="it has 9 pictures, but the frame needs number 10"):
        video_picture(path, 9)


def test_what_is_no_video_leaves_nothing_behind(tmp_path):
    path = tmp_path / "a.mp4"
    path.write_bytes(b"\0\0\0\x18ftypmp42" + bytes(200))
    with pytest.raises(FrameError, match="a.mp4: the video cannot be decoded"):
        video_picture(path, 0)
    assert not list(unpacked_folder().iterdir())
