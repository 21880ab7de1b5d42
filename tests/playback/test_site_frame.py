from dataclasses import dataclass

import numpy as np
import pytest
from site_reader import read_site_file

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.playback.site_frame import frame_file
from unstructured_mg.playback.site_options import SiteOptions

OPTIONS = SiteOptions(texture_size=64, quality=95)


@dataclass(frozen=True)
class Painted:
    image: np.ndarray

    def pixels(self):
        return self.image


def gradient(height, width, blue):
    y, x = np.mgrid[:height, :width]
    return np.stack([255 * x / width, 255 * y / height, np.full_like(x, blue)], 2).astype(np.uint8)


def surface():
    """A tetrahedron: four faces, and every corner with a uv of its own."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1.5, 0], [0, 0, 2.0]]) + [3, -40, 0.25]
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)
    uv = np.random.default_rng(0).random((12, 2))
    return vertices, faces, uv, np.arange(12, dtype=np.int32).reshape(4, 3)


def key(points, uv):
    """Faces as sorted rows, whichever corner they begin with."""
    rows = np.concatenate([points, uv], axis=2)
    first = rows[:, :, 3].argmin(axis=1)
    rows = np.take_along_axis(rows, (first[:, None, None] + np.arange(3)[:, None]) % 3, axis=1)
    return rows[np.lexsort(rows[:, 0, ::-1].T)]


def test_a_frame_is_what_was_captured_to_half_a_step():
    vertices, faces, uv, face_uv = surface()
    images = tuple(Painted(gradient(32, 48, blue)) for blue in (20, 200))
    material = np.array([1, 0, 1, 1], np.int32)
    mesh = TexturedMesh(vertices, faces, uv, face_uv, None, images, material)
    file = read_site_file(frame_file(mesh, "a:7", "frames/a_7", OPTIONS))
    assert file.name == "frames/a_7" and file.header["frame"] == "a:7" and file.header["steps"] == 1
    downwards = np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1)
    ours = key(file.positions[0][file.faces], file.uv[file.faces])
    theirs = key(vertices[faces], downwards[face_uv])
    assert np.abs(ours[..., :3] - theirs[..., :3]).max() <= 0.5e-4 * (1 + 1e-6)
    assert np.abs(ours[..., 3:] - theirs[..., 3:]).max() <= 0.5 * 0.25 / 48 * (1 + 1e-6)
    assert [image["faces"] for image in file.header["images"]] == [1, 3]
    for image, blue in zip(file.images, (20, 200), strict=True):
        assert np.abs(image.astype(int) - gradient(32, 48, blue)).mean() < 3


def test_large_images_are_scaled_down_in_proportion():
    vertices, faces, uv, face_uv = surface()
    mesh = TexturedMesh(vertices, faces, uv, face_uv, None, (Painted(gradient(128, 256, 90)),))
    (image,) = read_site_file(frame_file(mesh, "1", "frames/1", OPTIONS)).images
    assert image.shape == (32, 64, 3)
    assert np.abs(image.astype(int) - gradient(32, 64, 90)).mean() < 4


@pytest.mark.parametrize("colored", [True, False])
def test_a_frame_without_images_has_colours_or_nothing(colored):
    vertices, faces, uv, face_uv = surface()
    colors = np.arange(12, dtype=np.uint8).reshape(4, 3) * 20 if colored else None
    file = read_site_file(frame_file(TexturedMesh(vertices, faces, uv, face_uv, colors), "1", "frames/1", OPTIONS))
    assert file.uv is None and file.images == [] and len(file.positions[0]) == 4
    order = np.abs(file.positions[0][:, None] - vertices).sum(axis=2).argmin(axis=1)
    if colored:
        np.testing.assert_array_equal(file.colors[0], colors[order])
    else:
        assert len(file.colors) == 0


def test_more_than_65535_corners_have_wider_indices():
    count = 70_000
    vertices = np.random.default_rng(0).random((count, 3))
    start = np.arange(count - 2, dtype=np.int32)
    faces = np.stack([start, start + 1, start + 2], axis=1)
    file = read_site_file(frame_file(TexturedMesh(vertices, faces), "1", "frames/1", OPTIONS))
    drawn = np.sort(file.positions[0][file.faces].mean(axis=1), axis=0)
    assert np.abs(drawn - np.sort(vertices[faces].mean(axis=1), axis=0)).max() < 1e-4
