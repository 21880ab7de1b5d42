"""Where ffmpeg is."""

import shutil


def find_ffmpeg() -> str | None:
    """The system's ffmpeg, else the one that the ``video`` extra brings, else None."""
    program = shutil.which("ffmpeg")
    if program is not None:
        return program
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return None
