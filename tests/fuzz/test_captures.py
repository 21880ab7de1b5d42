"""Captures that were damaged or made up: whatever their bytes, a frame is read, or its fault names file and place.

A few cases of each kind run with all tests; ``make fuzz`` sets UMG_FUZZ_CASES for 10^5 in all.
"""

import os
import random
import resource
from contextlib import contextmanager

import numpy as np
import pytest
import trimesh
from broken_captures import BODY_FACES, BODY_UV, BODY_VERTICES, write_frame
from mutation import mutated
from PIL import Image
from sequence_samples import moved_body, vols_frame, vols_header

from unstructured_mg.capture.reader import open_capture
from unstructured_mg.errors import UserError

CASES = int(os.environ.get("UMG_FUZZ_CASES", "15"))
# What any of these small files may make the reader take, beyond what the process has.
MEMORY = 1 << 31


@contextmanager
def little_memory():
    """A promise of billions that is believed shows as a MemoryError and not as a machine that swaps."""
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def obj(folder):
    write_frame(folder, 1)
    return folder / "frame_0001.obj"


def mtl(folder):
    return obj(folder).with_suffix(".mtl")


def png(folder):
    return obj(folder).with_suffix(".png")


def jpeg(folder):
    write_frame(folder, 1, texture=False)
    path = folder / "frame_0001.jpg"
    Image.effect_noise((24, 16), 90).convert("RGB").save(path)
    return path


def ply_of(encoding):
    def ply(folder):
        folder.mkdir()
        mesh = trimesh.Trimesh(BODY_VERTICES, BODY_FACES, process=False)
        mesh.visual.vertex_colors = np.full((len(BODY_VERTICES), 4), 200, np.uint8)
        path = folder / "frame_0001.ply"
        path.write_bytes(trimesh.exchange.ply.export_ply(mesh, encoding=encoding))
        return path

    return ply


def glb(folder):
    folder.mkdir()
    visual = trimesh.visual.TextureVisuals(BODY_UV, image=Image.new("RGB", (8, 8), (200, 90, 40)))
    mesh = trimesh.Trimesh(BODY_VERTICES, BODY_FACES, visual=visual, process=False)
    path = folder / "frame_0001.glb"
    path.write_bytes(mesh.export(file_type="glb"))
    return path


def vols(folder):
    folder.mkdir()
    path = folder / "take.vols"
    path.write_bytes(vols_header(12, 2) + b"".join(vols_frame(12, n, moved_body(n), kind=1 + n) for n in (0, 1)))
    return path


def sidecar(folder):
    obj(folder)
    path = folder / "capture.json"
    path.write_text('{"fps": 30, "unit": "m", "up": "y", "floor": 0.0}')
    return path


SEEDS = {
    "obj": obj, "mtl": mtl, "png": png, "jpeg": jpeg, "ply text": ply_of("ascii"), "ply binary": ply_of("binary"),
    "glb": glb, "vols": vols, "capture.json": sidecar,
}  # fmt: skip


def assert_read_or_told(folder, path):
    """Open the capture and read all its good frames; every fault names a file in it."""
    try:
        capture = open_capture(folder)
        for fault in capture.faults:
            assert str(folder) in fault.file and fault.fault and fault.remedy
        for index in range(len(capture)):
            mesh = capture.read(index)
            assert np.isfinite(mesh.vertices).all() and np.isfinite(mesh.uv).all()
            assert len(mesh.faces) and 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices)
            if len(mesh.face_uv):
                assert 0 <= mesh.face_uv.min() <= mesh.face_uv.max() < len(mesh.uv)
            for texture in mesh.textures:
                assert texture.pixels().ndim == 3
    except UserError as error:
        assert str(folder) in str(error)


@pytest.mark.parametrize("kind", SEEDS)
def test_whatever_the_bytes_a_frame_is_read_or_its_fault_is_told(tmp_path, kind):
    folder = tmp_path / "capture"
    path = SEEDS[kind](folder)
    data = path.read_bytes()
    assert len(open_capture(folder)) >= 1  # the seed itself is good
    names = {each.name for each in folder.iterdir()}
    draw = random.Random(kind)
    with little_memory():
        for case in range(CASES):
            path.write_bytes(mutated(data, draw))
            try:
                assert_read_or_told(folder, path)
            except Exception as error:
                kept = tmp_path / f"case {case}"
                kept.write_bytes(path.read_bytes())
                raise AssertionError(f"case {case} of {kind}, kept in {kept}") from error
    assert {each.name for each in folder.iterdir()} == names  # nothing was written into the capture
