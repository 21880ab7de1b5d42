import json
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
import trimesh
from broken_captures import BODY_FACES, BODY_UV, BODY_VERTICES, break_frames, write_frames
from real_captures import real_capture

from unstructured_mg.capture.inspect import inspect_capture
from unstructured_mg.capture.obj_writer import write_obj
from unstructured_mg.capture.reader import open_capture


def test_a_sound_capture_has_nothing_to_report(tmp_path):
    inspection = inspect_capture(open_capture(write_frames(tmp_path, range(4)), fps=30))
    assert [(clip.name, clip.frames, clip.first, clip.last, clip.gaps) for clip in inspection.clips] == [
        (".", 4, 0, 3, ())
    ]
    assert inspection.new_connectivity == inspection.new_atlas == inspection.faults == inspection.warnings == ()
    frame = inspection.frames[0]
    assert (frame.id, frame.vertices, frame.faces) == ("0", len(BODY_VERTICES), len(BODY_FACES))
    assert (frame.width, frame.depth, frame.height) == pytest.approx((0.4, 0.4, 1.7), abs=1e-6)
    assert frame.texture_sizes == ((8, 8),) and frame.components == frame.significant_components == 1
    assert frame.boundary_edges == frame.nonmanifold_edges == frame.flat_faces == frame.uv_outside == 0
    assert frame.texture_overlap == pytest.approx(1.0, abs=0.02)  # front and back share the texture


def test_every_defect_is_counted(tmp_path):
    box = trimesh.creation.box((0.4, 1.7, 0.4))
    vertices = np.vstack([box.vertices, [[0, 0, 0], [0.3, 0, 0], [0, 0.01, 0], [0.1, 0, 0], [9, 9, 9]]])
    extra = np.array([[8, 9, 10], [9, 8, 11], [8, 10, 10]])  # a crumb, a flat one, a repeated corner
    faces = np.vstack([box.faces[1:], box.faces[3:4], box.faces[5:6, ::-1], extra]).astype(np.int32)
    uv = np.vstack([np.random.default_rng(0).random((8, 2)), np.full((3, 2), 0.5), [[0.5, 1.5]], [[0, 0]]])
    write_obj(tmp_path / "f1.obj", vertices, faces, uv, faces)
    frame = inspect_capture(open_capture(tmp_path, unit="m", up="y", floor=-0.85)).frames[0]
    assert (frame.unused_vertices, frame.collapsed_faces, frame.repeated_faces, frame.facing_away_faces) == (1, 1, 1, 1)
    assert (frame.components, frame.significant_components) == (2, 1)
    assert (frame.flat_faces, frame.flat_uv_faces, frame.uv_outside) == (1, 2, 1)
    # the box's missing face leaves 3 open edges, less those that the doubled face lies on; the crumb has 4
    edges = np.sort(np.vstack([box.faces[1:], box.faces[5:6], extra[:2]])[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert (frame.boundary_edges, frame.nonmanifold_edges) == ((uses == 1).sum(), (uses > 2).sum())
    assert frame.lowest == pytest.approx(0.0)


def test_changes_of_connectivity_and_atlas_are_named(tmp_path):
    write_frames(tmp_path, range(6))
    for number in (2, 3, 4, 5):  # other faces from frame 2, another atlas from frame 4
        uv = BODY_UV + (0.0 if number < 4 else 0.1)
        path = tmp_path / f"frame_{number:04d}.obj"
        write_obj(path, BODY_VERTICES, BODY_FACES[::-1], uv, BODY_FACES[::-1], (f"frame_{number:04d}.png",))
    inspection = inspect_capture(open_capture(tmp_path))
    assert (inspection.new_connectivity, inspection.new_atlas) == (("2",), ("4",))


def test_gaps_and_faults_by_id_the_same_for_any_number_of_workers(tmp_path):
    bad = break_frames(tmp_path / "one")
    write_frames(tmp_path / "two", [1, 2])
    capture = open_capture(tmp_path)
    calls = []
    inspection = inspect_capture(capture, progress=lambda done, total: calls.append((done, total)))
    with ProcessPoolExecutor(2) as executor:
        assert inspect_capture(capture, executor) == inspection
    assert inspection.fault_ids == tuple(f"one:{number}" for number in bad)
    assert inspection.clips[0].gaps == ((1, 12),) and inspection.clips[1].gaps == ()
    assert calls[-1] == (len(capture), len(capture))
    data = json.loads(json.dumps(inspection.to_json()))
    assert data["faults"][0]["remedy"] and data["frames"][0]["id"] == "one:0"


def test_a_real_capture_keeps_its_atlas_where_its_makers_kept_it():
    inspection = inspect_capture(open_capture(real_capture("tetavi_walk", "28:33")))
    assert inspection.new_atlas == ("30",)
    assert inspection.new_connectivity == ("29", "30", "31", "32")
    for frame in inspection.frames:
        assert frame.components == 1 and 50 < frame.boundary_edges < 150 and 1.7 < frame.height < 1.9
