import io
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from scipy.ndimage import gaussian_filter
from scipy.spatial import Delaunay

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.playback.camera import Camera, fit_camera, view_rotation
from unstructured_mg.playback.render import Drawable, drawable_step, render
from unstructured_mg.synthesis.transition import Transition


def smooth_image(height, width, seed=0):
    noise = np.random.default_rng(seed).random((height, width, 3))
    smooth = gaussian_filter(noise, (3, 3, 0))
    return np.uint8(255 * (smooth - smooth.min()) / np.ptp(smooth))


def quad(image, corners=((-1, 0, -1), (1, 0, -1), (1, 0, 1), (-1, 0, 1))):
    """Facing -y, the image upright on it."""
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    return Drawable(np.array(corners, np.float64), faces, uv, faces, (image,))


def parallel(height, width, scale, azimuth=-np.pi / 2, elevation=0.0):
    rotation = view_rotation(azimuth, elevation)
    return Camera(-5 * rotation[2], rotation, scale, height, width, perspective=False)


def psnr(one, other):
    return 10 * np.log10(255**2 / max(np.mean((one.astype(float) - other.astype(float)) ** 2), 1e-12))


def bilinear(image, u, v):
    height, width = image.shape[:2]
    x, y = np.clip(u * width - 0.5, 0, width - 1), np.clip((1 - v) * height - 0.5, 0, height - 1)
    x0, y0 = x.astype(int), y.astype(int)
    x1, y1 = np.minimum(x0 + 1, width - 1), np.minimum(y0 + 1, height - 1)
    fx, fy = (x - x0)[..., None], (y - y0)[..., None]
    top, bottom = (1 - fx) * image[y0, x0] + fx * image[y0, x1], (1 - fx) * image[y1, x0] + fx * image[y1, x1]
    return (1 - fy) * top + fy * bottom


def rays(camera):
    x = (np.arange(camera.width) + 0.5 - camera.width / 2) / camera.scale
    y = (camera.height / 2 - np.arange(camera.height) - 0.5) / camera.scale
    return x[None, :, None] * camera.rotation[0] + y[:, None, None] * camera.rotation[1] + camera.rotation[2]


def test_a_textured_quad_that_faces_the_camera_shows_its_image():
    image = smooth_image(90, 120)
    corners = [(-1, 0, -0.75), (1, 0, -0.75), (1, 0, 0.75), (-1, 0, 0.75)]
    camera = parallel(90, 120, 60.0)
    assert (render(quad(image, corners), camera, samples=1).image == image).all()
    assert psnr(render(quad(image, corners), camera).image, image) >= 40
    assert (render(quad(image, corners), camera).coverage == 255).all()


def test_texture_is_perspective_correct():
    image = smooth_image(70, 60, 1)
    drawable = quad(image, [(-1, -0.8, -1), (1, -0.8, -1), (1, 1.2, 1), (-1, 1.2, 1)])
    camera = fit_camera([drawable.vertices], height=150, width=170, azimuth=-1.2, elevation=0.3, field_of_view=0.9)
    found = render(drawable, camera, samples=1)
    # Ray and plane: u runs along x, v along (0, 2, 2) from the first corner.
    normal = np.cross([2, 0, 0], [0, 2, 2])
    ray = rays(camera)
    depth = ((drawable.vertices[0] - camera.position) @ normal) / (ray @ normal)
    hit = camera.position + depth[..., None] * ray - drawable.vertices[0]
    u, v = hit[..., 0] / 2, hit[..., 1] / 2
    inside = (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
    assert (found.coverage == 255 * inside).all()
    expected = bilinear(image, u, v)
    assert np.abs(found.image - expected)[inside].max() <= 0.5 + 1e-6
    assert (found.image[~inside] == 255).all()


def test_a_floor_that_passes_under_the_camera_is_cut_and_not_dropped():
    image = smooth_image(64, 64, 2)
    drawable = quad(image, [(-3, -9, 0), (3, -9, 0), (3, 9, 0), (-3, 9, 0)])
    camera = Camera(np.array([0.2, 0.0, 1.0]), view_rotation(-np.pi / 2, 0.4), 60.0, 90, 110)
    found = render(drawable, camera, samples=1)
    ray = rays(camera)
    depth = -1.0 / ray[..., 2]
    hit = camera.position + depth[..., None] * ray
    u, v = hit[..., 0] / 6 + 0.5, hit[..., 1] / 18 + 0.5
    inside = (depth > 0.01) & (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
    assert (found.coverage == 255 * inside).all()
    assert np.abs(found.image - bilinear(image, u, v))[inside].max() <= 0.5 + 1e-6


def test_nearer_surfaces_hide_farther_ones_in_any_order_of_faces():
    # Two planes that cross on the picture's middle column: each is in front on one side.
    vertices = np.array(
        [(-1, -1, -1), (1, 1, -1), (1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1), (1, -1, 1), (-1, 1, 1)], np.float64
    )
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.int32)
    colors = np.repeat(np.array([[255, 0, 0], [0, 0, 255]], np.uint8), 4, axis=0)
    for camera in (parallel(60, 60, 30.0), fit_camera([vertices], height=60, width=60, azimuth=-np.pi / 2)):
        found = render(Drawable(vertices, faces, colors=colors), camera)
        middle = found.image[30]
        seen = np.flatnonzero(found.coverage[30] == 255)
        assert (middle[seen[seen < 30]] == [255, 0, 0]).all()
        assert (middle[seen[seen >= 30]] == [0, 0, 255]).all()
        other = render(Drawable(vertices, faces[::-1].copy(), colors=colors), camera)
        assert (other.image == found.image).all()


def test_both_sides_are_drawn():
    image = smooth_image(40, 40)
    drawable = quad(image)
    camera = parallel(50, 50, 20.0)
    flipped = replace(drawable, faces=drawable.faces[:, ::-1].copy(), face_uv=drawable.face_uv[:, ::-1].copy())
    assert (render(flipped, camera, shading=0.5).image == render(drawable, camera, shading=0.5).image).all()


def test_there_are_no_cracks_between_neighbours():
    rng = np.random.default_rng(3)
    flat = np.concatenate([rng.uniform(-1, 1, (4000, 2)), [(-1, -1), (1, -1), (1, 1), (-1, 1)]])
    vertices = np.column_stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]])
    drawable = Drawable(vertices, Delaunay(flat).simplices.astype(np.int32))
    camera = fit_camera([vertices], height=233, width=317, azimuth=-1.4, elevation=0.2)
    coverage = render(drawable, camera).coverage
    outline = render(replace(drawable, faces=np.array([[4000, 4001, 4002], [4000, 4002, 4003]], np.int32)), camera)
    assert (coverage == outline.coverage).all()


def test_coverage_is_the_projected_area():
    turn = np.linspace(0, 2 * np.pi, 721)[:-1]
    rim = np.stack([np.cos(turn), np.zeros(720), np.sin(turn)], axis=1)
    faces = np.array([[720, i, (i + 1) % 720] for i in range(720)], np.int32)
    disc = Drawable(np.vstack([rim, [[0, 0, 0]]]), faces)
    coverage = render(disc, parallel(200, 200, 80.0), samples=4).coverage
    np.testing.assert_allclose(coverage.sum() / 255, np.pi * 80**2, rtol=1e-3)


def test_every_face_takes_its_own_texture():
    red, blue = np.full((4, 4, 3), (255, 0, 0), np.uint8), np.full((8, 2, 3), (0, 0, 255), np.uint8)
    drawable = replace(quad(red), images=(red, blue), face_material=np.array([1, 0], np.int32))
    image = render(drawable, parallel(20, 20, 10.0)).image
    assert (image[15, 18] == [0, 0, 255]).all() and (image[4, 1] == [255, 0, 0]).all()


def test_textures_finer_than_the_picture_are_averaged():
    stripes = np.zeros((512, 512, 3), np.uint8)
    stripes[:, ::2] = 255
    image = render(quad(stripes), parallel(40, 40, 20.0)).image
    assert np.abs(image[1:-1, 1:-1].astype(int) - 128).max() <= 1


def test_light_falls_as_documented():
    drawable = replace(quad(smooth_image(4, 4)), images=())
    camera = parallel(10, 10, 5.0)
    facing = 1 / np.linalg.norm([0.35, 0.45, 1.0])
    expected = 200 * (1 - 0.65 * (1 - facing))
    assert (render(drawable, camera).image == round(expected)).all()
    assert (render(drawable, camera, shading=0).image == 200).all()


def test_background_shows_through_in_proportion():
    half = quad(smooth_image(4, 4), [(-1, 0, -1), (0.05, 0, -1), (0.05, 0, 1), (-1, 0, 1)])
    drawable = replace(half, images=(), colors=np.zeros((4, 3), np.uint8))
    backdrop = np.zeros((20, 20, 3), np.uint8)
    backdrop[:] = np.arange(20, dtype=np.uint8)[:, None, None] * 10
    found = render(drawable, parallel(20, 20, 10.0), background=backdrop)
    assert (found.image[:, :10] == 0).all()
    assert (found.image[:, 11:] == backdrop[:, 11:]).all()
    assert (found.coverage[:, 10] == 128).all()
    assert (found.image[:, 10] == (backdrop[:, 10] + 1) // 2).all()


def test_the_same_bytes_from_many_threads():
    drawable = quad(smooth_image(50, 50))
    camera = fit_camera([drawable.vertices], height=80, width=90, azimuth=-1.0, elevation=0.2)
    first = render(drawable, camera, shading=0.4).image
    with ThreadPoolExecutor(4) as pool:
        for image in pool.map(lambda _: render(drawable, camera, shading=0.4).image, range(8)):
            assert (image == first).all()


def test_a_step_is_drawn_with_its_own_texture():
    mesh = quad(smooth_image(4, 4))
    textures = []
    for level in (40, 120, 200):
        data = io.BytesIO()
        Image.new("L", (8, 8), level).save(data, "PNG")
        textures.append(data.getvalue())
    vertices = np.stack([mesh.vertices + [0, step, 0] for step in (-1, 0, 1)])
    transition = Transition(
        5, 9, 2, vertices, mesh.faces, mesh.uv, mesh.face_uv, tuple(textures), ".png", None, PlanarRigid(), {}
    )
    for step, level in ((-1, 40), (0, 120), (1, 200)):
        drawable = drawable_step(transition, step)
        assert (drawable.vertices == vertices[step + 1]).all()
        assert (drawable.images[0] == level).all()
    for step in (-2, 2):
        with pytest.raises(ValueError, match="step: expected -1 .. 1"):
            drawable_step(transition, step)


MESH = quad(np.zeros((2, 2, 3), np.uint8))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"vertices": np.full((4, 3), np.nan)}, "vertices: expected finite"),
        ({"faces": np.array([[0, 1, 4], [0, 1, 2]], np.int32)}, r"faces: expected indices in 0\.\.3"),
        ({"faces": np.array([[0, 1, -1], [0, 1, 2]], np.int32)}, r"faces: expected indices in 0\.\.3"),
        ({"face_uv": np.array([[0, 1, 9], [0, 1, 2]], np.int32)}, r"face_uv: expected indices in 0\.\.3"),
        ({"face_uv": np.zeros((1, 3), np.int32)}, "face_uv: expected 2 faces"),
        ({"uv": np.full((4, 2), np.inf)}, "uv: expected finite"),
        ({"face_material": np.array([0, 1], np.int32)}, r"face_material: expected indices in 0\.\.0"),
        ({"images": (np.zeros((2, 2), np.uint8),)}, r"images: expected \(height, width, 3\) uint8"),
        ({"colors": np.zeros((3, 3), np.uint8)}, r"colors: expected \(4, 3\)"),
    ],
)
def test_what_would_read_outside_an_array_is_named(change, message):
    with pytest.raises(ValueError, match=message):
        render(replace(MESH, **change), parallel(8, 8, 4.0))


def test_bad_arguments_are_named():
    with pytest.raises(ValueError, match="samples: expected 1 or more"):
        render(MESH, parallel(8, 8, 4.0), samples=0)
    with pytest.raises(ValueError, match="background: expected"):
        render(MESH, parallel(8, 8, 4.0), background=np.zeros((4, 4, 3), np.uint8))
