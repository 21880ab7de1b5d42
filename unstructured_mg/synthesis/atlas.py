"""The one atlas that all frames of a transition share."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.geometry.components import face_components
from unstructured_mg.geometry.laplacian import face_areas
from unstructured_mg.geometry.normals import face_normals
from unstructured_mg.geometry.tracing import TracingSurface
from unstructured_mg.synthesis.texels import cover_texels, to_pixels

# A texture counts as overlapping where more than this share of its texels lies well inside two faces: single folded
# slivers do not cost a capture its own, sharper atlas.
OVERLAP_SHARE = 2e-3
# Atlases made here are this much wider than the sum of their charts' boxes at first; then charts shrink until they fit.
LARGEST_SIDE = 8192


@dataclass(frozen=True)
class Atlas:
    """Non-overlapping places of all faces in one image.

    Attributes
    ----------
    uv : (q, 2) float64 in [0, 1], v upwards
    face_uv : (m, 3) int32
    height, width : pixels of the image
    captured : True where every chart is as captured (perhaps shifted and scaled with its whole image)
    """

    uv: np.ndarray
    face_uv: np.ndarray
    height: int
    width: int
    captured: bool


def build_atlas(
    vertices: np.ndarray,
    faces: np.ndarray,
    uv: np.ndarray,
    face_uv: np.ndarray,
    face_material: np.ndarray | None,
    sizes: list[tuple[int, int]],
    texture_size: int = 0,
    padding: int = 4,
) -> Atlas:
    """An atlas for a template: the captured one where it is sound, so that texture stays as sharp as captured.

    Several materials are put side by side. Where charts overlap, or uvs leave [0, 1], charts are packed anew at their
    captured resolution; a chart that overlaps itself is cut into pieces that face one axis, those if need be into
    single faces.

    Parameters
    ----------
    vertices (n, 3), faces (m, 3), uv (q, 2), face_uv (m, 3), face_material (m,) or None : the template, as TexturedMesh
    sizes : (height, width) of the image of each material
    texture_size : longest side of the atlas in pixels at most; 0 for no limit but 8192
    padding : pixels between charts packed anew
    """
    limit = texture_size or LARGEST_SIDE
    material = np.zeros(len(faces), np.int64) if face_material is None else face_material.astype(np.int64)
    has_uv = len(uv) > 0 and face_uv.shape == faces.shape
    # Captured charts may stick out of the image by a pixel or two.
    slack = 2 / max(1, min(min(size) for size in sizes))
    inside = has_uv and bool(np.isfinite(uv).all() and uv.min() >= -slack and uv.max() <= 1 + slack)
    if inside:
        corner = uv[face_uv].clip(0, 1)
        height, width = (max(size[i] for size in sizes) for i in (0, 1))
        columns = int(np.ceil(np.sqrt(len(sizes))))
        rows = -(-len(sizes) // columns)
        cell = np.stack([material % columns, rows - 1 - material // columns], axis=1)[:, None]
        corner = (corner + cell) / (columns, rows)
        height, width = _limited(height * rows, width * columns, limit)
        owner, _, twice = cover_texels(to_pixels(corner, height, width), height, width)
        if twice <= OVERLAP_SHARE * max(int((owner >= 0).sum()), 1):
            if len(sizes) == 1:
                return Atlas(uv.clip(0, 1), face_uv.astype(np.int32), height, width, True)
            return _indexed(corner, height, width, True)
    pixels = np.array([[w, h] for h, w in sizes], np.float64)[np.minimum(material, len(sizes) - 1)]
    shapes, labels = _charts(vertices, faces, uv, face_uv, material, pixels, has_uv)
    corner, side = _pack(shapes, labels, limit, padding)
    return _indexed(corner / side, side, side, False)


def _limited(height: int, width: int, limit: int) -> tuple[int, int]:
    shrink = min(1.0, limit / max(height, width))
    return max(1, round(height * shrink)), max(1, round(width * shrink))


def _indexed(corner: np.ndarray, height: int, width: int, captured: bool) -> Atlas:
    """Corner places as shared uvs: equal places are one uv."""
    uv, face_uv = np.unique(corner.reshape(-1, 2), axis=0, return_inverse=True)
    return Atlas(uv.clip(0, 1), face_uv.reshape(-1, 3).astype(np.int32), height, width, captured)


def _charts(
    vertices: np.ndarray,
    faces: np.ndarray,
    uv: np.ndarray,
    face_uv: np.ndarray,
    material: np.ndarray,
    pixels: np.ndarray,
    has_uv: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Charts that do not overlap themselves: corner shapes (m, 3, 2) in pixels and chart labels (m,)."""
    m = len(faces)
    scale = 1.0
    bad = np.ones(m, bool)
    shapes, labels = np.zeros((m, 3, 2)), np.zeros(m, np.int64)
    if has_uv:
        shapes = uv[face_uv] * (pixels[:, None] * (1, -1))
        shapes = np.where(np.isfinite(shapes), shapes, 0.0)
        key = np.column_stack([faces.ravel(), shapes.reshape(-1, 2), np.repeat(material, 3)])
        _, joined = np.unique(key, axis=0, return_inverse=True)
        labels = face_components(int(joined.max()) + 1, joined.reshape(m, 3)).astype(np.int64)
        bad = _overlapping(shapes, labels)
        u, v = shapes[:, 1] - shapes[:, 0], shapes[:, 2] - shapes[:, 0]
        covered = 0.5 * np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum()
        scale = float(np.sqrt(covered / max(face_areas(vertices, faces).sum(), 1e-300)))
    else:
        scale = float(np.sqrt(0.5 * np.prod(pixels[0]) / max(face_areas(vertices, faces).sum(), 1e-300)))
    if bad.any():
        rest = np.flatnonzero(bad)
        normals = face_normals(vertices, faces[rest])
        axis = np.abs(normals).argmax(axis=1)
        facing = 2 * axis + (np.take_along_axis(normals, axis[:, None], 1)[:, 0] < 0)
        joined = faces[rest].astype(np.int64) * 6 + facing[:, None]
        piece = face_components(6 * len(vertices), joined).astype(np.int64)
        flat = np.stack([np.delete(vertices, i, axis=1) for i in range(3)])[axis[:, None], faces[rest]]
        shapes[rest], labels[rest] = flat * scale, labels.max() + 1 + piece
        still = rest[_overlapping(shapes[rest], piece)]
        if len(still):
            shapes[still] = TracingSurface(vertices, faces[still]).layout * scale
            labels[still] = labels.max() + 1 + np.arange(len(still))
    _, labels = np.unique(labels, return_inverse=True)
    return shapes, labels.reshape(-1)


def _overlapping(shapes: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """(m,) bool: faces of charts that overlap themselves."""
    order = np.argsort(labels, kind="stable")
    starts = np.flatnonzero(np.r_[True, np.diff(labels[order]) != 0])
    bad = np.zeros(len(labels), bool)
    for chart in np.split(order, starts[1:]):
        low = shapes[chart].min(axis=(0, 1))
        size = shapes[chart].max(axis=(0, 1)) - low
        # Small charts are looked at closely enough, huge ones coarsely enough.
        zoom = float(np.clip(256 / max(float(size.max()), 1e-9), 1e-3, 16.0))
        width, height = (np.ceil(size * zoom).astype(int) + 1).tolist()
        owner, _, twice = cover_texels((shapes[chart] - low) * zoom, height, width)
        bad[chart] = twice > OVERLAP_SHARE * max(int((owner >= 0).sum()), 1)
    return bad


def _pack(shapes: np.ndarray, labels: np.ndarray, limit: int, padding: int) -> tuple[np.ndarray, int]:
    """Shelf packing of the charts' boxes into a square: corner places (m, 3, 2) in pixels, and the square's side.

    Sides are multiples of 256; where even ``limit`` is too small all charts shrink alike.
    """
    count = int(labels.max()) + 1
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, labels, shapes.min(axis=1))
    np.maximum.at(high, labels, shapes.max(axis=1))
    size = high - low
    order = np.lexsort((np.arange(count), -size[:, 0], -size[:, 1]))
    total = float(((size[:, 0] + 2 * padding) * (size[:, 1] + 2 * padding)).sum())
    side = min(limit, 256 * max(1, int(np.ceil(np.sqrt(total) / 256))))
    shrink = 1.0
    while True:
        origins = _shelves(size * shrink + 2 * padding, order, side)
        if origins is not None:
            break
        if side < limit:
            side = min(limit, side + 256)
        else:
            shrink *= 0.96
            padding = padding if shrink > 0.1 else 0
    return (shapes - low[labels][:, None]) * shrink + (origins[labels] + padding)[:, None], side


def _shelves(size: np.ndarray, order: np.ndarray, side: int) -> np.ndarray | None:
    """Origins (count, 2) of boxes put on shelves from the highest to the lowest; None where they do not fit."""
    origins = np.zeros_like(size)
    x = y = shelf = 0.0
    for chart in order:
        width, height = size[chart]
        if x + width > side:
            x, y, shelf = 0.0, y + shelf, 0.0
        if x + width > side or y + height > side:
            return None
        origins[chart] = x, y
        x, shelf = x + width, max(shelf, height)
    return origins
