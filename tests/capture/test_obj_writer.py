import numpy as np
import trimesh
from PIL import Image

from unstructured_mg.capture.obj_writer import write_obj


def sphere():
    ball = trimesh.creation.icosphere(1)
    return np.array(ball.vertices), np.array(ball.faces, np.int32)


def numbers(path, word):
    rows = [line.split()[1:] for line in path.read_text().splitlines() if line.split()[0] == word]
    return np.array([[part.split("/") for part in row] for row in rows])


def test_another_reader_finds_the_same_triangles_and_image(tmp_path):
    """trimesh reads the file; every seam vertex comes apart there, so triangles are compared, corner by corner."""
    vertices, faces = sphere()
    random = np.random.default_rng(0)
    uv = random.random((len(faces) * 3, 2))
    face_uv = random.permutation(len(faces) * 3).reshape(-1, 3).astype(np.int32)
    Image.new("RGB", (4, 4), (10, 20, 30)).save(tmp_path / "body.png")
    write_obj(tmp_path / "body.obj", vertices, faces, uv, face_uv, ("body.png",))
    read = trimesh.load(tmp_path / "body.obj", process=False)
    np.testing.assert_allclose(read.vertices[read.faces], vertices[faces], atol=5.1e-8)
    np.testing.assert_allclose(read.visual.uv[read.faces], uv[face_uv], atol=5.1e-8)
    assert read.visual.material.image.getpixel((0, 0)) == (10, 20, 30)


def test_every_face_has_its_own_material(tmp_path):
    vertices, faces = sphere()
    material = np.arange(len(faces), dtype=np.int32) % 3
    uv = np.zeros((1, 2))
    write_obj(tmp_path / "a.obj", vertices, faces, uv, np.zeros_like(faces), ("0.png", "1.png", "2.png"), material)
    written, current = {}, None
    for line in (tmp_path / "a.obj").read_text().splitlines():
        word, *rest = line.split()
        if word == "usemtl":
            current = rest[0]
        elif word == "f":
            written[tuple(int(corner.split("/")[0]) - 1 for corner in rest)] = current
    assert written == {tuple(face.tolist()): f"material_{m}" for face, m in zip(faces, material, strict=True)}
    images = [line.split()[1] for line in (tmp_path / "a.mtl").read_text().splitlines() if line.startswith("map_Kd")]
    assert images == ["0.png", "1.png", "2.png"]


def test_colours_stand_behind_the_vertices_and_no_material_is_named(tmp_path):
    vertices, faces = sphere()
    colors = np.random.default_rng(0).integers(0, 256, (len(vertices), 3), np.uint8)
    none = np.zeros((0, 3), np.int32)
    write_obj(tmp_path / "a.obj", vertices, faces, np.zeros((0, 2)), none, colors=colors)
    rows = numbers(tmp_path / "a.obj", "v")[:, :, 0].astype(float)
    np.testing.assert_allclose(rows[:, :3], vertices, atol=5.1e-8)
    np.testing.assert_array_equal(np.round(rows[:, 3:] * 255), colors)
    np.testing.assert_array_equal(numbers(tmp_path / "a.obj", "f")[:, :, 0].astype(int), faces + 1)
    assert [path.name for path in tmp_path.iterdir()] == ["a.obj"]
    assert "mtl" not in (tmp_path / "a.obj").read_text()
