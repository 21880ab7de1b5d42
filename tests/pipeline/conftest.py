from pathlib import Path

import pytest
from small_build import OPTIONS, Built, quiet

from unstructured_mg.capture.procedural import write_procedural
from unstructured_mg.pipeline.build import build


@pytest.fixture(scope="session")
def capture(tmp_path_factory) -> Path:
    """A hundred small frames: the figure stands, waves, squats, and stands again."""
    folder = tmp_path_factory.mktemp("procedural") / "capture"
    write_procedural(folder, frames=100, faces=1500, texture_size=64)
    return folder


@pytest.fixture(scope="session")
def built(capture, tmp_path_factory) -> Built:
    work = tmp_path_factory.mktemp("built") / "work"
    build(capture, work, OPTIONS, 2, quiet())
    return Built(capture, work, OPTIONS)
