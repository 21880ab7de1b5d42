import numpy as np
from textured_pairs import ArrayTexture, grid, pattern, psnr

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.synthesis.images import captured_images
from unstructured_mg.synthesis.project import project_colors, smooth_normals

UP = np.array([0, 0, 1.0])


def painted(size, height):
    vertices, faces = grid(10, 10)
    column, row = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5)
    pixels = pattern(np.stack([column / size, 1 - row / size], -1), finest=30).astype(np.uint8)
    return TexturedMesh(
        vertices + height * UP, faces, vertices[:, :2].copy(), faces, None, (ArrayTexture(pixels),), None
    )


def test_colours_come_from_the_nearest_surface_point():
    mesh = painted(256, 0.0)
    place = np.random.default_rng(0).uniform(0.02, 0.98, (2000, 2))
    points = np.column_stack([place, np.full(2000, 0.01)])
    colors, seen = project_colors(mesh, captured_images(mesh), points, np.broadcast_to(UP, (2000, 3)), 0.02, 0.5)
    assert seen.all() and psnr(colors, pattern(place, finest=30)) > 42


def test_surface_too_far_or_facing_away_gives_no_colour():
    mesh = painted(64, 0.0)
    points = np.array([[0.5, 0.5, 0.01], [0.5, 0.5, 0.01], [0.5, 0.5, 0.05]])
    normals = np.array([UP, -UP, UP])
    _, seen = project_colors(mesh, captured_images(mesh), points, normals, 0.03, 0.5)
    assert seen.tolist() == [True, False, False]


def test_each_material_has_its_image_and_vertex_colours_do_without():
    one, two = painted(32, 0.0), painted(64, 0.0)
    half = (one.vertices[one.faces].mean(axis=1)[:, 0] > 0.5).astype(np.int32)
    colors = np.where(one.vertices[:, :1] > 0.5, 200, [10, 20, 30]).astype(np.uint8)
    mesh = TexturedMesh(
        one.vertices, one.faces, one.uv, one.face_uv, colors, (ArrayTexture(np.zeros((8, 8, 3), np.uint8)),
        two.textures[0]), half,
    )  # fmt: skip
    points = np.array([[0.21, 0.37, 0], [0.83, 0.71, 0.0]])
    got, seen = project_colors(mesh, captured_images(mesh), points, np.broadcast_to(UP, (2, 3)), 0.01, 0.5)
    assert seen.all() and np.abs(got[0]).max() < 1e-3
    assert np.abs(got[1] - pattern(points[1, :2], finest=30)).max() < 6
    got, _ = project_colors(mesh, [], points, np.broadcast_to(UP, (2, 3)), 0.01, 0.5)
    np.testing.assert_allclose(got, [[10, 20, 30], [200, 200, 200]], atol=1e-3)


def test_normals_are_of_unit_length_even_where_sheets_cancel():
    vertices, faces = grid(2, 2)
    normals = smooth_normals(vertices, np.concatenate([faces, faces[:, ::-1]]))
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1)
