import numpy as np
import pytest
from textured_pairs import grid, pattern, psnr

from unstructured_mg.synthesis.advect import advect_images, advect_vertices
from unstructured_mg.synthesis.flow import FlowSolver
from unstructured_mg.synthesis.flow_surface import build_flow_surface
from unstructured_mg.synthesis.images import spline_through
from unstructured_mg.synthesis.project import smooth_normals
from unstructured_mg.synthesis.texels import locate_texels

SIZE = 96


@pytest.fixture(scope="module")
def plane():
    vertices, faces = grid(12, 12)
    surface = build_flow_surface(vertices, faces, vertices[faces][:, :, :2], 0.05)
    return surface, locate_texels(surface, SIZE, SIZE, 2)


def texels_of(shift):
    column, row = np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5)
    place = np.stack([column / SIZE, 1 - row / SIZE], -1) - shift
    image = np.ones((SIZE, SIZE, 4), np.float32)
    image[:, :, :3] = pattern(place, finest=25)
    return image


def picture(shift):
    return spline_through(texels_of(shift))


def constant_corners(surface, vector):
    tracing = surface.tracing
    a, b = (surface.vertices[tracing.faces[:, i], :2] for i in (0, 1))
    x = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    y = np.stack([-x[:, 1], x[:, 0]], axis=1)
    inside = np.stack([x @ vector, y @ vector], axis=1)
    return np.repeat(inside[:, None], 3, axis=1)


def test_a_shift_is_synthesized_at_every_step(plane):
    surface, texels = plane
    shift = np.array([0.07, -0.04])
    images = advect_images(
        surface, texels, constant_corners(surface, shift), picture(0 * shift), picture(shift), steps=7
    )
    for i, image in enumerate(images, start=1):
        assert psnr(image[10:-10, 10:-10], texels_of(shift * i / 8)[10:-10, 10:-10, :3]) > 40


def test_without_flow_it_is_a_cross_fade(plane):
    surface, texels = plane
    start, end = texels_of(0.0), texels_of(0.2)
    images = advect_images(surface, texels, np.zeros((len(surface.tracing.faces), 3, 2)), picture(0.0), picture(0.2), 3)
    for i, image in enumerate(images, start=1):
        truth = start[:, :, :3] * (1 - i / 4) + end[:, :, :3] * (i / 4)
        assert np.abs(image.astype(float) - truth).max() <= 0.51


def test_swapping_both_ends_reverses_the_sequence(plane):
    surface, texels = plane
    corners = constant_corners(surface, np.array([0.05, 0.02]))
    one = advect_images(surface, texels, corners, picture(0.0), picture(0.1), 5)
    other = advect_images(surface, texels, -corners, picture(0.1), picture(0.0), 5)
    assert np.abs(one.astype(int) - other[::-1]).max() <= 1


def test_vertex_colours_move_alike():
    vertices, faces = grid(60, 60)
    surface = build_flow_surface(vertices, faces, vertices[faces][:, :, :2], 1.0)
    solver = FlowSolver(surface.vertices, smooth_normals(surface.vertices, surface.tracing.faces), surface.tracing)
    shift = np.array([0.07, -0.04])
    colors = advect_vertices(
        solver,
        constant_corners(surface, shift),
        pattern(surface.vertices[:, :2], finest=8),
        pattern(surface.vertices[:, :2] - shift, finest=8),
        7,
    )
    middle = np.abs(surface.vertices[:, :2] - 0.5).max(axis=1) < 0.4
    for i, step in enumerate(colors, start=1):
        assert psnr(step[middle], pattern(surface.vertices[middle, :2] - shift * i / 8, finest=8)) > 40


def test_images_of_another_size_are_refused(plane):
    surface, texels = plane
    with pytest.raises(ValueError, match="start, end"):
        advect_images(
            surface,
            texels,
            np.zeros((len(surface.tracing.faces), 3, 2)),
            spline_through(texels_of(0)[1:].copy()),
            picture(0),
            3,
        )
