"""A new texture atlas for every frame: seeded charts, flattened on planes, packed with gutters."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components, dijkstra

from unstructured_mg import _native

STEEPEST = 0.30  # cosine: a face that leans further from its chart's plane goes to another chart
GUTTER = 4.0  # texels between charts; each keeps half of it on every side
OVERSAMPLING = 2  # overlap inside a chart is looked for on a grid this many times finer than the texture


@dataclass(frozen=True)
class Atlas:
    """Where every face lies in the texture.

    Attributes
    ----------
    uv : (q, 2) float64 in 0..1, v upwards
    face_uv : (m, 3) int32 into ``uv``; charts share no uv
    chart : (m,) int32 chart of each face
    owner : (size, size) int32 face under each texel centre, top row first; -1 in the gutters
    weights : (size, size, 3) float32 barycentric weights on it
    """

    uv: np.ndarray
    face_uv: np.ndarray
    chart: np.ndarray
    owner: np.ndarray
    weights: np.ndarray


def unwrap(
    vertices: np.ndarray, faces: np.ndarray, neighbours: np.ndarray, density: np.ndarray, size: int, seed: int
) -> Atlas:
    """Cut a closed surface into charts and lay them out on a square of ``size`` texels.

    Parameters
    ----------
    vertices : (n, 3) float64, metres, in the pose that is flattened
    faces : (m, 3) int32
    neighbours : (m, 3) int32 the face across each edge c -> c + 1
    density : (m,) float64 relative texel density wanted on each face
    size : texels along the square's side
    seed : chooses the cuts, the charts' turns and their places
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    normals = cross / np.maximum(area, 1e-300)[:, None]
    label = _grow(normals, area, (a + b + c) / 3, neighbours, int(generator.integers(34, 56)), generator)
    for _ in range(4):
        label, axis = _make_flat(label, normals, area, neighbours)
        plane = _planes(axis, generator)
        scale = _mean(label, density, area)
        flat = np.einsum("fki,fji->fkj", vertices[faces], plane[label]) * scale[label][:, None, None]
        corners, _ = _pack(flat, label, size)
        clash = _overlaps(corners, size)
        if not clash.any():
            break
        # What lies over another part of its chart becomes a chart of its own.
        label = np.where(clash, len(scale) + label, label)
    owner = np.full((size, size), -1, np.int32)
    weights = np.zeros((size, size, 3), np.float32)
    _native.raster_charts(np.ascontiguousarray(corners), owner, weights, np.zeros(len(faces), np.uint8), size, size)
    keys = label[:, None].astype(np.int64) * len(vertices) + faces
    _, first, face_uv = np.unique(keys, return_index=True, return_inverse=True)
    uv = corners.reshape(-1, 2)[first] / size
    uv[:, 1] = 1 - uv[:, 1]
    return Atlas(uv, face_uv.reshape(-1, 3).astype(np.int32), label.astype(np.int32), owner, weights)


def _dual(neighbours: np.ndarray, keep: np.ndarray, lengths: np.ndarray | None = None) -> sp.csr_matrix:
    count = len(neighbours)
    rows = np.repeat(np.arange(count), 3)[keep.ravel()]
    values = np.ones(len(rows)) if lengths is None else lengths.ravel()[keep.ravel()]
    return sp.csr_matrix((values, (rows, neighbours.ravel()[keep.ravel()])), (count, count))


def _grow(
    normals: np.ndarray,
    area: np.ndarray,
    centres: np.ndarray,
    neighbours: np.ndarray,
    count: int,
    generator: np.random.Generator,
) -> np.ndarray:
    """Labels (m,): the nearest of ``count`` random seeds, where bends make the way longer."""
    bend = 1 - np.einsum("fi,fci->fc", normals, normals[neighbours])
    lengths = np.linalg.norm(centres[:, None] - centres[neighbours], axis=2) * (1 + 14 * bend) + 1e-6
    graph = _dual(neighbours, np.ones_like(neighbours, bool), lengths)
    share = area / area.sum()
    first = generator.choice(len(area), size=4 * count, replace=False, p=share)
    # Of random faces, take in turn the one farthest from those already taken.
    spread = normals[first] * 0.12 + centres[first]
    taken = [0]
    gap = np.linalg.norm(spread - spread[0], axis=1)
    for _ in range(count - 1):
        taken.append(int(np.argmax(gap)))
        gap = np.minimum(gap, np.linalg.norm(spread - spread[taken[-1]], axis=1))
    seeds = first[taken]
    _, _, source = dijkstra(graph, indices=seeds, min_only=True, return_predecessors=True)
    return np.searchsorted(np.sort(seeds), source)


def _mean(label: np.ndarray, values: np.ndarray, area: np.ndarray) -> np.ndarray:
    count = int(label.max()) + 1
    return np.bincount(label, values * area, count) / np.maximum(np.bincount(label, area, count), 1e-300)


def _axes(label: np.ndarray, normals: np.ndarray, area: np.ndarray) -> np.ndarray:
    axis = np.stack([_mean(label, normals[:, i], area) for i in range(3)], 1)
    return axis / np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), 1e-300)


def _make_flat(
    label: np.ndarray, normals: np.ndarray, area: np.ndarray, neighbours: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Connected charts in which no face is steep: steep faces go to a neighbouring chart or become charts."""
    usable = area > 0
    for attempt in range(4):
        label = _connected(label, neighbours)
        axis = _axes(label, normals, area)
        # Only at first: taking and splitting in turn might go on for ever.
        for _ in range(8 if attempt == 0 else 0):
            steep = np.flatnonzero(np.einsum("fi,fi->f", normals, axis[label]) < STEEPEST)
            offers = label[neighbours[steep]]
            fit = np.einsum("fi,fci->fc", normals[steep], axis[offers])
            best = np.argmax(fit, 1)
            good = fit[np.arange(len(steep)), best] >= STEEPEST
            if not good.any():
                break
            label[steep[good]] = offers[np.arange(len(steep)), best][good]
        if attempt == 0:
            label = _connected(label, neighbours)
            axis = _axes(label, normals, area)
        steep = usable & (np.einsum("fi,fi->f", normals, axis[label]) < STEEPEST)
        if not steep.any():
            return label, axis
        label = np.where(steep, len(axis) + label, label)
    label[steep] = label.max() + 1 + np.arange(np.count_nonzero(steep))
    label = np.unique(label, return_inverse=True)[1]
    return label, _axes(label, normals, area)


def _connected(label: np.ndarray, neighbours: np.ndarray) -> np.ndarray:
    return connected_components(_dual(neighbours, label[:, None] == label[neighbours]), directed=False)[1].astype(
        np.int64
    )


def _planes(axis: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """For each chart axis two directions (charts, 2, 3) that span its plane, turned at random, right-handed."""
    helper = np.where(np.abs(axis[:, 2:]) < 0.8, [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    right = np.cross(helper, axis)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    up = np.cross(axis, right)
    angle = generator.uniform(0, 2 * np.pi, len(axis))[:, None]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * right + s * up, -s * right + c * up], 1)


def _pack(flat: np.ndarray, label: np.ndarray, size: int) -> tuple[np.ndarray, float]:
    """Corners (m, 3, 2) in texels, y down, and texels a metre: charts side by side on shelves as large as they fit."""
    count = int(label.max()) + 1
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, label, flat.min(1))
    np.maximum.at(high, label, flat.max(1))
    extent = high - low
    lying = extent[:, 1] > extent[:, 0]
    # Charts lie on their long side: shelves waste less.
    flat = np.where(lying[label][:, None, None], np.stack([flat[..., 1], -flat[..., 0]], -1), flat)
    corner = np.where(lying[:, None], np.stack([low[:, 1], -high[:, 0]], 1), low)
    extent = np.where(lying[:, None], extent[:, ::-1], extent)
    order = np.lexsort((np.arange(count), -extent[:, 1]))
    small, large = 0.0, 4.0 * size / float(np.sqrt(extent.prod(1).sum()))
    for _ in range(24):
        scale = 0.5 * (small + large)
        if _shelves(extent[order] * scale + GUTTER, size) is None:
            large = scale
        else:
            small = scale
    places = np.empty((count, 2))
    fitted = _shelves(extent[order] * small + GUTTER, size)
    places[order] = fitted
    texels = (flat - corner[label][:, None]) * small + places[label][:, None] + 0.5 * GUTTER
    return np.stack([texels[..., 0], size - texels[..., 1]], -1), small


def _shelves(boxes: np.ndarray, size: int) -> np.ndarray | None:
    """Lower left corners of boxes (highest first) on shelves of a square, or None where they do not fit."""
    places = np.empty_like(boxes)
    x = y = shelf = 0.0
    for i, (width, height) in enumerate(boxes.tolist()):
        if x + width > size:
            y += shelf
            x = shelf = 0.0
        if shelf == 0.0:
            shelf = height
        if width > size or y + height > size:
            return None
        places[i] = x, y
        x += width
    return places


def _overlaps(corners: np.ndarray, size: int) -> np.ndarray:
    fine = size * OVERSAMPLING
    owner = np.full((fine, fine), -1, np.int32)
    clash = np.zeros(len(corners), np.uint8)
    weights = np.empty((fine, fine, 3), np.float32)
    _native.raster_charts(np.ascontiguousarray(corners * OVERSAMPLING), owner, weights, clash, fine, fine)
    return clash.astype(bool)
