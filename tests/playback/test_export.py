import errno
import json
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from export_frames import picture
from moving_toy import FACE_UV, FACES, UV, load_transition, moving_capture, moving_links, placed
from PIL import Image
from toy_capture import toy_capture

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.capture.texture import Texture
from unstructured_mg.errors import UserError
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.playback import export_obj as obj
from unstructured_mg.playback.export import export_walk
from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.walk import capture_walk, random_walk

LINKS = moving_links((20, 68), (30, 54))


def prepared(tmp_path, frames=40, textures=("a.jpg",), **space):
    handles = []
    for name in textures:
        (tmp_path / name).write_bytes(b"bytes of " + name.encode())
        handles.append(Texture(tmp_path / name))
    capture = moving_capture(100, textures=tuple(handles), **space)
    walk = random_walk(build_graph(capture, LINKS), capture, frames, 4, start=50)
    return capture, walk


def export(tmp_path, capture, walk, out=None, options=None, **rest):
    out = out or tmp_path / "out"
    assert export_walk(walk, capture, load_transition, out, options, **rest) == len(list(out.glob("*.obj")))
    return out


def read_obj(path):
    rows = [line.split() for line in path.read_text().splitlines()]
    vertices, uv = ([[float(x) for x in row[1:]] for row in rows if row[0] == kind] for kind in ("v", "vt"))
    corners = np.array([[c.split("/") for c in row[1:]] for row in rows if row[0] == "f"], int) - 1
    return np.array(vertices), np.array(uv), corners[..., 0], corners[..., 1]


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_what_is_written_is_the_walk_in_the_captures_own_space(tmp_path):
    capture, walk = prepared(tmp_path, unit=0.01, up="y", floor=3.0)
    out = export(tmp_path, capture, walk)
    data = json.loads((out / "walk.json").read_text())
    assert (data["fps"], data["unit"], data["up"], data["seed"], data["kind"]) == (30.0, 0.01, "y", 4, "random")
    assert data["floor"] == pytest.approx(3.0)
    assert data["ended"] is None and data["start"] == capture.frame_id(50)
    from_metres = np.linalg.inv(capture.to_metres())
    own = lambda p: p @ from_metres[:3, :3].T + from_metres[:3, 3]  # noqa: E731
    assert [entry["file"] for entry in data["frames"]] == [f"frame_{i:05d}.obj" for i in range(1, 41)]
    sources = set()
    for time, entry in enumerate(data["frames"], start=50):
        vertices, uv, faces, face_uv = read_obj(out / entry["file"])
        np.testing.assert_allclose(vertices, own(placed(time)), atol=1e-6)
        np.testing.assert_array_equal(uv, UV)
        np.testing.assert_array_equal(faces, FACES)
        np.testing.assert_array_equal(face_uv, FACE_UV)
        sources.add(entry["source"])
        if entry["source"] == "capture":
            assert set(entry) == {"file", "source", "frame", "world"}
            place, picture = placed(capture.index_of(entry["frame"])), (".jpg", b"bytes of a.jpg")
        else:
            assert set(entry) == {"file", "source", "transition", "step", "world"}
            source, target = (capture.index_of(entry["transition"][end]) for end in ("source", "target"))
            place, picture = placed(source + entry["step"]), (".png", f"{source}-{target}{entry['step']:+d}".encode())
        world = np.array(entry["world"])
        np.testing.assert_allclose(own(place) @ world[:3, :3].T + world[:3, 3], vertices, atol=1e-6)
        stem = out / entry["file"]
        assert stem.with_suffix(picture[0]).read_bytes() == picture[1]
        assert f"map_Kd {stem.with_suffix(picture[0]).name}\n" in stem.with_suffix(".mtl").read_text()
    assert sources == {"capture", "transition"}
    assert len(list(out.iterdir())) == 3 * 40 + 1


def test_workers_change_nothing(tmp_path):
    capture, walk = prepared(tmp_path)
    alone, told = export(tmp_path, capture, walk), []
    with ProcessPoolExecutor(2) as executor:
        out = export(tmp_path, capture, walk, tmp_path / "other", executor=executor,
                     progress=lambda done, total: told.append((done, total)))  # fmt: skip
    assert contents(alone) == contents(out)
    assert told == sorted(told) and told[-1] == (40, 40)


def test_only_an_earlier_export_is_replaced(tmp_path):
    capture, walk = prepared(tmp_path, 3, ("a.jpg", "b.png"))
    out = export(tmp_path, capture, walk)
    with pytest.raises(UserError, match="out: the folder is not empty"):
        export(tmp_path, capture, walk)
    export(tmp_path, *prepared(tmp_path, 5), force=True)
    assert len(contents(out)) == 3 * 5 + 1
    (out / "thesis.tex").write_text("years of work")
    with pytest.raises(UserError, match=r"out: the folder holds thesis.tex, which no export wrote"):
        export(tmp_path, capture, walk, force=True)
    assert len(contents(out)) == 3 * 5 + 2


@pytest.mark.parametrize("parallel", [False, True])
def test_a_full_disk_leaves_nothing_and_says_so(tmp_path, monkeypatch, parallel):
    capture, walk = prepared(tmp_path, 30)
    write = obj.write_obj

    def full(path, *arguments):
        if path.name == "frame_00007.obj":
            raise OSError(errno.ENOSPC, "No space left on device")
        write(path, *arguments)

    monkeypatch.setattr(obj, "write_obj", full)
    with ThreadPoolExecutor(2) as pool, pytest.raises(UserError, match="out: the disk is full, and nothing was kept"):
        export(tmp_path, capture, walk, executor=pool if parallel else None)
    assert {path.name for path in tmp_path.iterdir()} == {"a.jpg"}


def test_an_interrupted_export_leaves_nothing(tmp_path):
    capture, walk = prepared(tmp_path)

    def interrupted(source, target):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        export_walk(walk, capture, interrupted, tmp_path / "out")
    assert {path.name for path in tmp_path.iterdir()} == {"a.jpg"}


def test_an_unknown_format_lists_those_there_are(tmp_path):
    with pytest.raises(UserError, match="--format abc: there is no such format; give one of obj"):
        export(tmp_path, *prepared(tmp_path), options=ExportOptions(format="abc"))
    assert not (tmp_path / "out").exists()


def test_a_plain_capture_is_exported_too(tmp_path):
    capture, _ = prepared(tmp_path, unit=0.01, up="y", floor=3.0)
    export_walk(capture_walk(capture), capture, None, tmp_path / "out")
    data = json.loads((tmp_path / "out" / "walk.json").read_text())
    assert (data["kind"], data["inputs"], len(data["frames"])) == ("capture", {}, 100)
    assert all(entry["world"] == np.eye(4).tolist() for entry in data["frames"])
    from_metres = np.linalg.inv(capture.to_metres())
    for index in (0, 57, 99):
        vertices = read_obj(tmp_path / "out" / f"frame_{index + 1:05d}.obj")[0]
        np.testing.assert_allclose(vertices, placed(index) @ from_metres[:3, :3].T + from_metres[:3, 3], atol=1e-6)


def test_other_rates_numbers_and_turns_show_the_same_frames_elsewhere(tmp_path):
    capture, walk = prepared(tmp_path, 9)
    plain = contents(export(tmp_path, capture, walk))
    options = ExportOptions(fps=15.0, first_number=99999, bounce=True, hold=1)
    out = export(tmp_path, capture, walk, tmp_path / "other", options)
    data = json.loads((out / "walk.json").read_text())
    assert data["fps"] == 15.0
    assert data["options"] == {"fps": 15.0, "first_number": 99999, "bounce": True, "hold": 1}
    shown = [1, 3, 5, 7, 9, 9, 7, 5, 3, 1]
    names = [f"frame_{number:06d}.obj" for number in range(99999, 99999 + len(shown))]
    assert [entry["file"] for entry in data["frames"]] == names
    for name, number in zip(names, shown, strict=True):
        theirs = (out / name).read_bytes().split(b"\n", 1)[1]
        assert theirs == plain[f"frame_{number:05d}.obj"].split(b"\n", 1)[1]


def test_an_export_in_another_axis_and_unit_says_so(tmp_path):
    capture, walk = prepared(tmp_path, 3, unit=0.01, up="y", floor=3.0)
    out = export(tmp_path, capture, walk, options=ExportOptions(up="z", unit=0.001))
    data = json.loads((out / "walk.json").read_text())
    assert (data["up"], data["unit"], data["floor"]) == ("z", 0.001, pytest.approx(30.0))
    vertices = read_obj(out / "frame_00001.obj")[0]
    np.testing.assert_allclose(vertices, placed(50) * 1000 + [0, 0, 30], atol=1e-4)


def test_fewer_faces_and_smaller_pictures_in_every_frame(tmp_path):
    side = 8
    y, x = np.mgrid[: side + 1, : side + 1].reshape(2, -1) / side
    at = np.arange(side * (side + 1)).reshape(side, side + 1)[:, :side].ravel()
    faces = np.concatenate([np.stack([at, at + 1, at + side + 2], 1), np.stack([at, at + side + 2, at + side + 1], 1)])
    (tmp_path / "a.png").write_bytes(picture((9, 8, 7), size=(60, 30)).data)

    def mesh(index):
        vertices = np.stack([x, y, 0.1 * np.sin(6 * x + index)], 1)
        textures = (Texture(tmp_path / "a.png"),)
        return TexturedMesh(
            vertices, faces.astype(np.int32), np.stack([x, y], 1), faces.astype(np.int32), None, textures
        )

    capture = toy_capture(3, mesh_of=mesh)
    options = ExportOptions(decimate=40, texture_size=20)
    export_walk(capture_walk(capture), capture, None, tmp_path / "out", options)
    connectivities = set()
    for index in range(3):
        vertices, uv, corners, _ = read_obj(tmp_path / "out" / f"frame_{index + 1:05d}.obj")
        assert 20 < len(corners) <= 40
        np.testing.assert_allclose(vertices[:, 2], 0.1 * np.sin(6 * vertices[:, 0] + index), atol=1e-6)
        connectivities.add(corners.tobytes())
        with Image.open(tmp_path / "out" / f"frame_{index + 1:05d}.png") as image:
            assert image.size == (10, 20)
    assert len(connectivities) == 1
    assert json.loads((tmp_path / "out" / "walk.json").read_text())["options"] == {"decimate": 40, "texture_size": 20}
