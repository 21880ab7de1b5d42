"""The pictures of a video, unpacked once into a folder of the user's cache."""

import os
import shutil
import subprocess
import tempfile
from functools import lru_cache
from pathlib import Path

from unstructured_mg.capture.ffmpeg import find_ffmpeg
from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.stretch import file_stamp, whole_digest

VIDEO_SUFFIXES = (".mp4", ".webm", ".mov", ".mkv", ".m4v")


def video_picture(path: Path, index: int) -> Path:
    """The file of picture ``index`` (from 0) of a video, a JPEG of highest quality.

    The first call for a video unpacks all of it, in order, into ``unpacked_folder``; later ones, by any process, find
    it there. Deleting that folder costs nothing but unpacking again.

    Raises
    ------
    FrameError : the video cannot be decoded, or has no such picture; there is no ffmpeg
    """
    folder = _unpacked(path, file_stamp(path))
    picture = folder / f"{index + 1:06d}.jpg"
    if not picture.is_file():
        count = len(list(folder.glob("*.jpg")))
        raise FrameError(
            path,
            f"it has {count} pictures, but the frame needs number {index + 1}",
            "export the video with one picture a frame",
        )
    return picture


def unpacked_folder() -> Path:
    """Where videos are unpacked: the folder that the variable ``UMG_CACHE`` names, else the user's own cache."""
    given = os.environ.get("UMG_CACHE")
    cache = (
        Path(given) if given else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "unstructured_mg"
    )
    return cache / "videos"


@lru_cache(maxsize=64)
def _unpacked(path: Path, stamp: tuple[int, int]) -> Path:
    whole = unpacked_folder() / whole_digest(path).hex()[:32]
    if whole.is_dir():
        return whole
    program = _ffmpeg(path)
    try:
        whole.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(prefix="partial-", dir=whole.parent))
    except OSError as error:
        raise FrameError(
            path,
            f"it cannot be unpacked into {whole.parent} ({error.strerror})",
            "name a folder that can be written by the variable UMG_CACHE",
        ) from None
    try:
        # the video's own chroma sampling and the finest quantiser: what little is lost is below the video's own losses
        command = [program, "-nostdin", "-v", "error", "-i", str(path.absolute()), "-map", "0:v:0", "-fps_mode"]
        command += ["passthrough", "-pix_fmt", "yuvj420p", "-q:v", "1", "-qmin", "1", "%06d.jpg"]
        result = subprocess.run(command, cwd=partial, capture_output=True, text=True, errors="replace")
        if result.returncode or not any(partial.iterdir()):
            reason = " ".join(result.stderr.split())[-200:] or "it holds no pictures"
            raise FrameError(path, f"the video cannot be decoded ({reason})", "export it again as H.264 in MP4")
        try:
            partial.rename(whole)
        except OSError:
            if not whole.is_dir():  # another process was faster, which is as good
                raise
    except OSError as error:
        raise FrameError(
            path, f"it cannot be unpacked into {whole.parent} ({error.strerror})", "make room there, or set UMG_CACHE"
        ) from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return whole


def _ffmpeg(path: Path) -> str:
    program = find_ffmpeg()
    if program is None:
        raise FrameError(path, "reading a video needs ffmpeg", "install it, or: pip install 'unstructured_mg[video]'")
    return program
