import random
from pathlib import Path

import DracoPy
import numpy as np
import pytest
import trimesh
from broken_captures import BODY_FACES, BODY_UV, BODY_VERTICES

from unstructured_mg.capture.draco import decode_draco
from unstructured_mg.capture.frame_error import FrameError

FILE = Path("a.drc")


def test_a_mesh_with_uvs_and_colours_comes_back():
    colors = np.random.default_rng(0).integers(0, 256, (len(BODY_VERTICES), 3), dtype=np.uint8)
    data = DracoPy.encode(BODY_VERTICES, BODY_FACES, quantization_bits=16, tex_coord=BODY_UV, colors=colors)
    mesh = decode_draco(FILE, 0, data)
    ours, theirs = (
        trimesh.Trimesh(*m, process=False) for m in ((mesh.vertices, mesh.faces), (BODY_VERTICES, BODY_FACES))
    )
    assert abs(ours.volume / theirs.volume - 1) < 1e-4
    nearest = np.linalg.norm(mesh.vertices[:, None] - BODY_VERTICES, axis=2).argmin(axis=1)
    np.testing.assert_allclose(mesh.vertices, BODY_VERTICES[nearest], atol=1e-4)
    np.testing.assert_allclose(mesh.attributes[mesh.uv], BODY_UV[nearest], atol=1e-3)
    np.testing.assert_array_equal(mesh.attributes[mesh.colors], colors[nearest])


def test_what_is_no_draco_mesh_names_the_byte():
    data = DracoPy.encode(BODY_VERTICES, BODY_FACES)
    with pytest.raises(FrameError, match="byte 7: expected DRACO, found 58"):
        decode_draco(FILE, 7, b"X" + data[1:])
    with pytest.raises(FrameError, match=r"byte 14: expected a triangle mesh \(1\), found 0"):
        decode_draco(FILE, 7, DracoPy.encode(BODY_VERTICES))
    for end in range(len(data) - 1):
        with pytest.raises(FrameError, match=r"byte"):
            decode_draco(FILE, 0, data[:end])


def test_damaged_bytes_are_faults_or_meshes_in_range():
    rng = random.Random(0)
    data = DracoPy.encode(BODY_VERTICES, BODY_FACES, tex_coord=BODY_UV)
    for _ in range(400):
        damaged = bytearray(data)
        for _ in range(rng.randrange(1, 4)):
            damaged[rng.randrange(len(damaged))] = rng.choice([0, 127, 128, 255, rng.randrange(256)])
        try:
            mesh = decode_draco(FILE, 0, bytes(damaged))
        except FrameError:
            continue
        assert mesh.faces.min() >= 0 and mesh.faces.max() < len(mesh.vertices)
