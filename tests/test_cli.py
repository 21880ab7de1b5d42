"""The command line as a user meets it: in a process of its own."""

import json
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from PIL import Image
from sequence_samples import UASTC_ARRAY, layer_picture, moved_body, vols_frame, vols_header


def umg(*arguments, **options):
    command = [sys.executable, "-c", "from unstructured_mg.cli import main; main()", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, **options)


def assert_one_sentence(result, *words):
    assert result.returncode == 2
    assert "Traceback" not in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    for word in words:
        assert word in result.stderr


def test_help_lists_every_command():
    shown = umg("--help").stdout
    for command in ("inspect", "build", "walk", "path", "convert", "report", "web", "view", "demo"):
        assert command in shown


def test_no_frames_is_one_sentence_and_nothing_is_written(tmp_path):
    (tmp_path / "capture").mkdir()
    (tmp_path / "capture" / "notes.txt").write_text("no frames here")
    assert_one_sentence(umg("build", tmp_path / "capture", "-o", tmp_path / "work"), str(tmp_path / "capture"))
    assert not (tmp_path / "work").exists()
    assert_one_sentence(umg("inspect", tmp_path / "capture"), str(tmp_path / "capture"))


def test_only_bad_frames_is_one_sentence(tmp_path):
    (tmp_path / "capture").mkdir()
    for number in range(3):
        (tmp_path / "capture" / f"frame_{number}.obj").write_text("v 0 0 0\nf 1 2 9\n")
    (tmp_path / "work").mkdir()
    assert_one_sentence(umg("build", tmp_path / "capture", "-o", tmp_path / "work"), str(tmp_path / "capture"))
    assert list((tmp_path / "work").iterdir()) == []


def test_a_bad_word_names_the_option_and_the_choices(tmp_path):
    (tmp_path / "capture").mkdir()
    result = umg("build", tmp_path / "capture", "-o", tmp_path / "work", "--blend", "nurbs")
    assert_one_sentence(result, "--blend", "volumetric_arap", "nurbs")


def test_what_is_no_work_folder_is_said_so(tmp_path):
    for command in (["walk", tmp_path, "--frames", 3, "-o", tmp_path / "out"], ["report", tmp_path],
                    ["web", tmp_path, "-o", tmp_path / "out"]):  # fmt: skip
        assert_one_sentence(umg(*command), "is not a work folder", "umg build")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["dance"], ["dance", "umg --help"]),
        (["build", "capture", "-o", "work", "--window", "wide"], ["--window", "wide", "umg build --help"]),
        (["build", "capture", "-o", "work", "--window", "1"], ["--window", "2"]),
        (["build", "capture"], ["--output", "umg build --help"]),
        (["build", "capture", "-o", "work", "--unit", "furlong"], ["--unit", "furlong", "inch"]),
        (["walk", "work", "--frames", "0", "-o", "out"], ["--frames", "umg walk --help"]),
        (["walk", "work", "--frames", "9", "-o", "out", "--fast"], ["--fast", "umg walk --help"]),
        (
            ["walk", "work", "--frames", "9", "-o", "out", "--format", "abc"],
            ["--format abc", "obj, ply, unity, glb, usd"],
        ),
        (["walk", "work", "--frames", "9", "-o", "out", "--format", "glb", "--up", "z"], ["--up", "glb", "y up"]),
        (["walk", "work", "--frames", "9", "-o", "out", "--texture-size", "0"], ["--texture-size", "got 0"]),
        (["web", "work"], ["-o SITE", "--serve"]),
        (["web", "work", "--serve"], ["is not a page's folder", "umg web"]),
        (["web", "work", "-o", "out", "--port", "8000"], ["--port", "--serve"]),
        (["web", "work", "--serve", "--decimate", "500"], ["--decimate", "-o SITE"]),
    ],
)
def test_misuse_is_one_sentence(tmp_path, arguments, words):
    places = {"capture", "work", "out"}
    assert_one_sentence(umg(*(tmp_path / word if word in places else word for word in arguments)), *words)
    assert list(tmp_path.iterdir()) == []


def test_convert_writes_a_capture_of_any_format_as_another(tmp_path):
    (tmp_path / "take").mkdir()
    frames = [vols_frame(13, i, moved_body(i), kind=int(i == 0), texture=UASTC_ARRAY) for i in range(3)]
    (tmp_path / "take" / "take.vols").write_bytes(vols_header(13, 4, textured=True) + b"".join(frames))
    result = umg("convert", tmp_path / "take", "-o", tmp_path / "out", "--unit", "cm", "--workers", 1)
    assert result.returncode == 0, result.stderr
    assert "1 frames cannot be used" in result.stdout and "3 frames are in" in result.stdout
    for i in range(3):
        mesh = trimesh.load(tmp_path / "out" / f"frame_{i + 1:05d}.obj", process=False)
        np.testing.assert_allclose(mesh.bounds, [100 * moved_body(i).min(0), 100 * moved_body(i).max(0)], atol=1e-3)
        with Image.open(tmp_path / "out" / f"frame_{i + 1:05d}.png") as image:
            assert np.abs(np.asarray(image).astype(int) - layer_picture(0)).max() <= 3
    scene, again = tmp_path / "scene", tmp_path / "again"
    assert umg("convert", tmp_path / "out", "-o", scene, "--format", "glb", "--fps", 24, "--workers", 1).returncode == 0
    assert umg("convert", scene, "-o", again, "--workers", 1).returncode == 0
    assert json.loads((again / "walk.json").read_text())["fps"] == 24
    for name in ("frame_00001", "frame_00003"):
        for suffix in (".obj", ".png"):
            if suffix == ".png":
                assert (again / (name + suffix)).read_bytes() == (tmp_path / "out" / (name + suffix)).read_bytes()
            else:
                found, wanted = (trimesh.load(f / (name + suffix), process=False) for f in (again, tmp_path / "out"))
                np.testing.assert_allclose(100 * found.bounds, wanted.bounds, atol=1e-4)  # glTF is in metres
    assert_one_sentence(umg("convert", tmp_path / "take", "-o", tmp_path / "b", "--format", "xyz"), "xyz", "obj")
    assert_one_sentence(
        umg("convert", tmp_path / "take", "-o", tmp_path / "b", "--capture-fps", "0"), "--capture-fps", "above 0"
    )
    assert_one_sentence(umg("convert", tmp_path / "take", "-o", tmp_path / "out"), str(tmp_path / "out"))
