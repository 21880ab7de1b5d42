"""Writing the procedural capture: the same bytes however many workers."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from PIL import Image

from unstructured_mg.capture.procedural import ProceduralCapture, write_procedural
from unstructured_mg.capture.reader import open_capture


def test_files_are_the_same_for_any_executor_and_match_the_capture(tmp_path):
    told = []
    write_procedural(
        tmp_path / "alone",
        frames=12,
        faces=1500,
        texture_size=128,
        progress=lambda done, total: told.append((done, total)),
    )
    # A spawned worker makes its own body: nothing of it may depend on the process.
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as executor:
        write_procedural(tmp_path / "other", frames=12, faces=1500, texture_size=128, executor=executor)
    assert told[-1] == (12, 12)
    names = sorted(path.name for path in (tmp_path / "alone").iterdir())
    frames = [f"frame_{i:04d}.{kind}" for i in range(12) for kind in ("obj", "mtl", "jpg")]
    assert names == sorted([*frames, "capture.json"])
    for name in names:
        assert (tmp_path / "alone" / name).read_bytes() == (tmp_path / "other" / name).read_bytes()

    mesh = ProceduralCapture(12, 1500, 128).frame_mesh(7)
    read = open_capture(tmp_path / "alone")
    assert (len(read), read.fps, read.unit, read.up, read.floor, read.warnings) == (12, 30.0, 1.0, "y", 0.0, ())
    assert np.abs(read.read(7).vertices - mesh.vertices).max() < 1e-7
    assert (read.read(7).faces == mesh.faces).all()
    lines = (tmp_path / "alone" / "frame_0007.obj").read_text().splitlines()
    rows = np.array([line.split()[1:] for line in lines if line.startswith("v ")], float)
    assert np.abs(np.stack([rows[:, 0], -rows[:, 2], rows[:, 1]], 1) - mesh.vertices).max() < 1e-7
    corners = np.array([[c.split("/") for c in line.split()[1:]] for line in lines if line.startswith("f ")], int) - 1
    assert (corners[:, :, 0] == mesh.faces).all()
    assert (corners[:, :, 1] == mesh.face_uv).all()
    assert "map_Kd frame_0007.jpg" in (tmp_path / "alone" / "frame_0007.mtl").read_text()
    picture = np.asarray(Image.open(tmp_path / "alone" / "frame_0007.jpg")).astype(float)
    assert np.abs(picture - mesh.pixels).mean() < 6
