import pytest

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.capture.frame_file import FrameFile
from unstructured_mg.capture.frame_reader import read_frame

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n"


@pytest.mark.parametrize(
    "text, fault",
    [
        ("v 0 0 0\nv 1 inf 0\nv 0 1 0\nf 1 2 3", "vertex 2 is not a finite number"),
        ("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3", "vertex 3 is not a finite number"),
        ("v 0 0 0\nv 1 0 0\nv 0 1e12 0\nf 1 2 3", "vertex 3 exceeds 1e.09"),
        (SQUARE + "vt nan 0\nf 1/1 2/2 3/4", "texture coordinate 4 is not a finite number"),
        (SQUARE + "vt -1e10 0\nf 1/1 2/2 3/4", "texture coordinate 4 exceeds 1e.09"),
        ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2", "none of its faces has any area"),
        (SQUARE + "f 1 1 2\nf 3 3 3", "none of its faces has any area"),
    ],
)
def test_values_no_room_can_use_are_refused(tmp_path, text, fault):
    path = tmp_path / "f1.obj"
    path.write_text(text)
    with pytest.raises(FrameError, match=fault):
        read_frame(FrameFile(".", 1, path), tmp_path)


def test_a_texture_without_coordinates_is_refused(tmp_path):
    (tmp_path / "f1.png").write_bytes(b"image")
    (tmp_path / "f1.obj").write_text(SQUARE + "f 1 2 3")
    with pytest.raises(FrameError, match="no texture coordinates"):
        read_frame(FrameFile(".", 1, tmp_path / "f1.obj"), tmp_path)


def test_format_is_chosen_by_suffix_in_any_case(tmp_path):
    (tmp_path / "f1.OBJ").write_text(SQUARE + "f 1/1 2/2 3/3\nf 1/1 3/3 4/2")
    mesh, tidied, raw = read_frame(FrameFile(".", 1, tmp_path / "f1.OBJ"), tmp_path)
    assert mesh.faces.shape == (2, 3) and mesh.face_uv.shape == (2, 3) and raw.files == (tmp_path / "f1.OBJ",)
