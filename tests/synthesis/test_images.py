import numpy as np
from textured_pairs import ArrayTexture, pattern, psnr

from unstructured_mg import _native
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.synthesis.images import captured_images, sample, spline_through


def square(uv, texture):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return TexturedMesh(vertices, faces, uv, faces, None, (ArrayTexture(texture),), None)


CORNERS = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])


def test_samples_at_texel_centres_are_the_texels():
    pixels = np.random.default_rng(0).integers(0, 256, (7, 9, 3)).astype(np.uint8)
    (image,) = captured_images(square(CORNERS, pixels))
    column, row = np.meshgrid(np.arange(9), np.arange(7))
    uv = np.stack([(column + 0.5) / 9, 1 - (row + 0.5) / 7], axis=-1).reshape(-1, 2)
    np.testing.assert_allclose(sample(image, uv).reshape(7, 9, 3), pixels, atol=1e-3)


def test_quadratics_are_sampled_exactly_between_texels():
    x, y = np.meshgrid(np.arange(20) + 0.5, np.arange(20) + 0.5)
    surface = lambda x, y: 100 + 2 * x - 3 * y + 0.1 * x * x - 0.2 * x * y  # noqa: E731
    image = spline_through(np.repeat(surface(x, y)[:, :, None], 4, axis=2).astype(np.float32))
    place = np.random.default_rng(1).uniform(6, 14, (100, 2))
    uv = np.stack([place[:, 0] / 20, 1 - place[:, 1] / 20], axis=1)
    np.testing.assert_allclose(sample(image, uv)[:, 0], surface(*place.T), atol=1e-3)


def test_background_never_bleeds_into_a_chart():
    size = 64
    column, row = np.meshgrid(np.arange(size) + 0.5, np.arange(size) + 0.5)
    truth = pattern(np.stack([column, row], -1) / size, finest=10)
    inside = (column > 16) & (column < 48) & (row > 16) & (row < 48)
    pixels = np.where(inside[:, :, None], truth, 0).astype(np.uint8)
    (image,) = captured_images(square(0.25 + 0.5 * CORNERS, pixels))
    edge = np.stack([np.full(100, 0.2501), np.linspace(0.26, 0.74, 100)], axis=1)
    expected = pattern(np.stack([edge[:, 0], 1 - edge[:, 1]], -1), finest=10)
    assert np.abs(sample(image, edge) - expected).max() < 12


def test_uvs_outside_the_image_repeat_it():
    pixels = np.random.default_rng(2).integers(0, 256, (16, 16, 3)).astype(np.uint8)
    (image,) = captured_images(square(CORNERS * 3 - 1, pixels))
    assert image.wrap
    uv = np.random.default_rng(3).uniform(0, 1, (50, 2))
    np.testing.assert_allclose(sample(image, uv - 1), sample(image, uv + 1), atol=2e-3)


def test_images_far_beyond_the_limit_are_averaged_down():
    column, row = np.meshgrid(np.arange(256) + 0.5, np.arange(256) + 0.5)
    pixels = pattern(np.stack([column, row], -1) / 256, finest=8).astype(np.uint8)
    (image,) = captured_images(square(CORNERS, pixels), limit=64)
    assert image.coefficients.shape == (64, 64, 4)
    place = np.random.default_rng(4).uniform(0.05, 0.95, (1000, 2))
    truth = pattern(np.stack([place[:, 0], 1 - place[:, 1]], -1), finest=8)
    assert psnr(sample(image, place), truth) > 40


def test_unknown_texels_are_filled_from_the_known_ones_only():
    generator = np.random.default_rng(5)
    image = np.zeros((37, 50, 4), np.float32)
    known = generator.random((37, 50)) < 0.03
    image[known] = np.column_stack([generator.uniform(50, 200, (known.sum(), 3)), np.ones(known.sum())])
    before = image.copy()
    image[~known, :3] = 999
    _native.fill_unknown(image, 37, 50)
    np.testing.assert_array_equal(image[known], before[known])
    assert (image[:, :, 3] == 1).all()
    assert image[~known, :3].min() >= before[known, :3].min() and image[~known, :3].max() <= before[known, :3].max()
    # A single known texel fills the whole image.
    lone = np.zeros((20, 33, 4), np.float32)
    lone[7, 11] = 10, 20, 30, 1
    _native.fill_unknown(lone, 20, 33)
    np.testing.assert_allclose(lone, np.broadcast_to([10, 20, 30, 1], lone.shape), rtol=1e-6)
