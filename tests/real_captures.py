"""Real captures for tests: frames unpacked from the folder that the variable UMG_CAPTURES names."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest


def real_capture(name: str, frames: str = ":", *options: str) -> Path:
    """The folder with frames ``A:B`` of a capture, unpacked once into a cache outside the project. Skips without it."""
    root = os.environ.get("UMG_CAPTURES")
    if not root:
        pytest.skip("UMG_CAPTURES is not set: no folder of real captures")
    key = "-".join([name, frames.replace(":", "_"), *options])
    folder = Path(tempfile.gettempdir()) / "unstructured_mg_captures" / key
    if not folder.is_dir():
        partial = folder.with_name(f"{folder.name}.{os.getpid()}")
        command = [sys.executable, str(Path(root) / "unpack.py"), name, str(partial), "--frames", frames, *options]
        subprocess.run(command, check=True)
        partial.rename(folder)
    return folder
