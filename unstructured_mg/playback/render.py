"""Meshes to pixels without a graphics driver: the same arrays give the same bytes, also in workers."""

import io
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from PIL import Image

from unstructured_mg import _native
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.playback.camera import Camera
from unstructured_mg.synthesis.transition import Transition

# Nearer than this (metres) nothing is drawn.
NEAR = 0.01
# Pixels a side of the textures that are kept for pictures: what a picture of a few hundred pixels can show of an atlas.
LARGEST = 1024


@dataclass(frozen=True)
class Drawable:
    """A triangle mesh with its textures decoded: what `render` draws.

    Attributes
    ----------
    vertices : (n, 3) float64, metres
    faces : (m, 3) int32
    uv : (q, 2) float64, v upwards; (0, 2) where there is none
    face_uv : (m, 3) int32; (0, 3) where there is no uv
    images : one (height, width, 3) uint8 array a material, sRGB, top row first
    face_material : (m,) int32 index into ``images``, or None where there is at most one
    colors : (n, 3) uint8, sRGB, or None; drawn where there are no images
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    face_uv: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), np.int32))
    images: tuple[np.ndarray, ...] = ()
    face_material: np.ndarray | None = None
    colors: np.ndarray | None = None


@dataclass(frozen=True)
class Rendering:
    """``image (height, width, 3) uint8``; ``coverage (height, width) uint8`` is the mesh's share, 255 for all."""

    image: np.ndarray
    coverage: np.ndarray


def drawable_frame(mesh: TexturedMesh) -> Drawable:
    """A captured frame with its textures decoded, those larger than LARGEST averaged down."""
    images = tuple(_reduced(texture.pixels()) for texture in mesh.textures) if len(mesh.face_uv) else ()
    return Drawable(mesh.vertices, mesh.faces, mesh.uv, mesh.face_uv, images, mesh.face_material, mesh.colors)


def drawable_step(transition: Transition, step: int) -> Drawable:
    """Step ``-k+1 .. k-1`` of a transition, in its source's captured place, textured as by `drawable_frame`.

    Raises ValueError for a step that is not stored.
    """
    if not -transition.k < step < transition.k:
        raise ValueError(f"step: expected {-transition.k + 1} .. {transition.k - 1}, got {step}")
    at = step + transition.k - 1
    images: tuple[np.ndarray, ...] = ()
    if transition.textures:
        with Image.open(io.BytesIO(transition.textures[at])) as image:
            images = (_reduced(np.asarray(image.convert("RGB"))),)
    colors = None if transition.colors is None else transition.colors[at]
    return Drawable(transition.vertices[at], transition.faces, transition.uv, transition.face_uv, images, None, colors)


def moved(drawable: Drawable, move: Callable[[np.ndarray], np.ndarray]) -> Drawable:
    """The same with its vertices moved by ``move``, which takes and gives (n, 3)."""
    return replace(drawable, vertices=move(drawable.vertices))


def render(
    drawable: Drawable,
    camera: Camera,
    *,
    background: np.ndarray | tuple[int, int, int] = (255, 255, 255),
    shading: float | None = None,
    plain_color: tuple[int, int, int] = (200, 200, 200),
    samples: int = 2,
) -> Rendering:
    """Draw a mesh, both sides of every triangle, over a background.

    Perspective-correct texture coordinates (one uv a face corner, so seams of the atlas are exact), bilinear texels,
    a depth buffer, and the mean of ``samples x samples`` samples a pixel. Textures much finer than the picture are
    first averaged down to about one texel a sample.

    Parameters
    ----------
    drawable : textured where it has images, else in vertex colours, else plain
    camera : where from, and how many pixels
    background : one colour, or a (height, width, 3) uint8 picture
    shading : 0 (colours as captured) to 1 (lit from beside the camera, from both sides: 35 % at grazing angles);
        default 0 for textures and colours, which carry their own light, and 1 for plain meshes
    plain_color : of a mesh with neither
    samples : a pixel, each way

    Raises
    ------
    ValueError
        For indices out of range, coordinates that are not finite, or sizes that do not fit together.
    """
    vertices, faces = _checked_mesh(drawable)
    if samples < 1:
        raise ValueError(f"samples: expected 1 or more, got {samples}")
    image = np.empty((camera.height, camera.width, 3), np.uint8)
    background = np.asarray(background, np.uint8)
    if background.shape not in ((3,), image.shape):
        raise ValueError(f"background: expected a colour or {image.shape}, got {background.shape}")
    image[...] = background
    coverage = np.zeros(image.shape[:2], np.uint8)
    points = camera.project(vertices)
    points[:, :2] *= samples

    images = drawable.images
    layout, texels = np.zeros((0, 3), np.int64), np.zeros(0, np.uint8)
    material = np.zeros(len(faces), np.int32)
    if images:
        values, face_values = np.ascontiguousarray(drawable.uv, np.float64), drawable.face_uv
        if drawable.face_material is not None:
            material = np.ascontiguousarray(drawable.face_material, np.int32)
        images = _thinned(drawable, points)
        sizes = np.array([pixels.size for pixels in images], np.int64)
        shapes = np.array([pixels.shape[:2] for pixels in images], np.int64)
        layout = np.column_stack([np.cumsum(sizes) - sizes, shapes])
        texels = np.concatenate([pixels.ravel() for pixels in images])
    else:
        colors = np.broadcast_to(np.array(plain_color, np.uint8), vertices.shape)
        values = np.ascontiguousarray(colors if drawable.colors is None else drawable.colors, np.float64)
        face_values = faces
    if shading is None:
        shading = 0.0 if images or drawable.colors is not None else 1.0
    _native.render(
        np.ascontiguousarray(points),
        faces,
        values,
        np.ascontiguousarray(face_values, np.int32),
        _shade(vertices, faces, camera, shading),
        texels,
        layout,
        material,
        image,
        coverage,
        camera.height,
        camera.width,
        samples,
        NEAR,
    )
    return Rendering(image, coverage)


def _checked_mesh(drawable: Drawable) -> tuple[np.ndarray, np.ndarray]:
    vertices = np.ascontiguousarray(drawable.vertices, np.float64)
    faces = np.ascontiguousarray(drawable.faces, np.int32)
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise ValueError(f"vertices: expected finite (n, 3), got {vertices.shape} or a coordinate that is not finite")
    _check_indices("faces", faces, len(vertices), len(faces))
    if drawable.colors is not None and drawable.colors.shape != vertices.shape:
        raise ValueError(f"colors: expected {vertices.shape}, got {drawable.colors.shape}")
    if drawable.images:
        _check_indices("face_uv", drawable.face_uv, len(drawable.uv), len(faces))
        if drawable.uv.shape[1:] != (2,) or not np.isfinite(drawable.uv).all():
            raise ValueError(f"uv: expected finite (q, 2), got {drawable.uv.shape} or a coordinate that is not finite")
        for pixels in drawable.images:
            if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.size == 0:
                raise ValueError(f"images: expected (height, width, 3) uint8, got {pixels.shape} {pixels.dtype}")
        material = drawable.face_material
        if material is not None:
            _check_indices("face_material", material[:, None].repeat(3, 1), len(drawable.images), len(faces))
    return vertices, faces


def _check_indices(name: str, indices: np.ndarray, below: int, count: int) -> None:
    if indices.shape != (count, 3):
        raise ValueError(f"{name}: expected {count} faces, got shape {indices.shape}")
    if count and (indices.min() < 0 or indices.max() >= below):
        raise ValueError(f"{name}: expected indices in 0..{below - 1}, got {indices.min()}..{indices.max()}")


def _shade(vertices: np.ndarray, faces: np.ndarray, camera: Camera, shading: float) -> np.ndarray:
    """(n,) float64 brightness a vertex: a soft light above the camera's left shoulder, whichever side is seen."""
    if shading == 0:
        return np.ones(len(vertices))
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Sums of area-weighted face normals; bincount adds in a fixed order.
    sums = np.stack(
        [np.bincount(faces.ravel(), normal[:, axis].repeat(3), minlength=len(vertices)) for axis in range(3)], axis=1
    )
    length = np.linalg.norm(sums, axis=1)
    light = camera.rotation.T @ (np.array([-0.35, 0.45, -1.0]) / np.linalg.norm([-0.35, 0.45, -1.0]))
    towards = camera.position - vertices if camera.perspective else np.broadcast_to(-camera.rotation[2], vertices.shape)
    side = np.where(np.einsum("ij,ij->i", sums, towards) < 0, -1.0, 1.0)
    facing = np.clip(side * (sums @ light) / np.where(length > 0, length, 1.0), 0, 1)
    return 1 - shading * 0.65 * (1 - np.where(length > 0, facing, 1.0))


def _thinned(drawable: Drawable, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """The textures, averaged down by a power of two where one sample would otherwise skip texels."""
    shapes = np.array([pixels.shape[:2] for pixels in drawable.images], np.float64)
    at = np.zeros(len(drawable.faces), np.int64) if drawable.face_material is None else drawable.face_material
    uv = drawable.uv[drawable.face_uv]
    texels = np.abs(_doubled_areas(uv)) * np.prod(shapes, axis=1)[at]
    ahead = points[:, 3] >= NEAR
    flat = points[:, :2] / np.where(ahead, points[:, 3], 1.0)[:, None]
    drawn = ahead[drawable.faces].all(axis=1)
    sampled = np.abs(_doubled_areas(flat[drawable.faces]))[drawn].sum()
    if sampled == 0:
        return drawable.images
    factor = 2 ** max(0, int(np.floor(np.log2(max(texels[drawn].sum() / sampled, 1.0)) / 2)))
    if factor == 1:
        return drawable.images
    return tuple(np.asarray(Image.fromarray(pixels).reduce(factor)) for pixels in drawable.images)


def _reduced(pixels: np.ndarray) -> np.ndarray:
    factor = 1
    while max(pixels.shape[:2]) > factor * LARGEST:
        factor *= 2
    return pixels if factor == 1 else np.asarray(Image.fromarray(pixels).reduce(factor))


def _doubled_areas(corners: np.ndarray) -> np.ndarray:
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
