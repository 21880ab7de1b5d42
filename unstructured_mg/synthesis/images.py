"""Captured images as projection reads them: float, with the gaps between charts filled from inside."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg import _native
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.synthesis.texels import cover_texels, to_pixels


@dataclass(frozen=True)
class Image:
    """A cubic spline through an image's texels: ``coefficients`` (height, width, 4) float32, sRGB 0..255 and 1.

    ``wrap``: it repeats outside [0, 1].
    """

    coefficients: np.ndarray
    wrap: bool = False


def captured_images(mesh: TexturedMesh, limit: int = 0) -> list[Image]:
    """The decoded images of a captured frame, one a material.

    What no face covers is filled smoothly from what faces cover, so that samples at a chart's rim take nothing from the
    background. Images whose longest side is ``limit * 2`` pixels or more (0: never) are reduced by whole factors first.
    """
    images = []
    for material, texture in enumerate(mesh.textures):
        pixels = texture.pixels()
        factor = max(pixels.shape[:2]) // limit if limit else 1
        if factor > 1:
            pixels = _reduce(pixels, factor)
        height, width = pixels.shape[:2]
        image = np.ones((height, width, 4), np.float32)
        image[:, :, :3] = pixels
        mine = mesh.face_uv if mesh.face_material is None else mesh.face_uv[mesh.face_material == material]
        corner = mesh.uv[mine]
        slack = 2 / min(height, width)
        wrap = bool(corner.size and (corner.min() < -slack or corner.max() > 1 + slack))
        if corner.size and not wrap:
            owner, _, _ = cover_texels(to_pixels(corner, height, width), height, width)
            if (owner >= 0).any():
                image[:, :, 3] = owner >= 0
                _native.fill_unknown(image, height, width)
        images.append(spline_through(image, wrap))
    return images


def spline_through(pixels: np.ndarray, wrap: bool = False) -> Image:
    """The spline through texels (height, width, 4) float32, whose memory it takes over."""
    _native.spline_filter(pixels, *pixels.shape[:2])
    return Image(pixels, wrap)


def _reduce(pixels: np.ndarray, factor: int) -> np.ndarray:
    height, width = (max(1, size // factor) for size in pixels.shape[:2])
    cut = pixels[: height * factor, : width * factor].astype(np.float32)
    if cut.shape[0] < height * factor or cut.shape[1] < width * factor:
        return pixels
    return cut.reshape(height, factor, width, factor, 3).mean(axis=(1, 3))


def sample(image: Image, uv: np.ndarray) -> np.ndarray:
    """Samples (p, 3) float32 at uvs (p, 2)."""
    height, width = image.coefficients.shape[:2]
    places = to_pixels(np.asarray(uv, np.float64), height, width)
    colors = np.empty((len(places), 4), np.float32)
    _native.sample_image(image.coefficients, height, width, places, int(image.wrap), colors)
    return colors[:, :3]
