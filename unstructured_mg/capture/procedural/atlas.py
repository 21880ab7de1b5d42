"""A new texture atlas for every frame: seeded charts, flattened on planes, packed with gutters."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components, dijkstra

from unstructured_mg import _native

LEVEL = 0.30  # cosine: a face that leans further from its chart's plane is offered to other charts
STEEPEST = 0.10  # cosine: no face leans further; patches of less than SMALL faces join a chart down to here
SMALL = 14
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
    label, axis = _flatten(label, normals, area, neighbours)
    for attempt in range(12):
        scale = _mean(label, density, area)
        flat = np.einsum("fki,fji->fkj", vertices[faces], _planes(axis)[label]) * scale[label][:, None, None]
        corners = _pack(_align(flat, label, area, generator), label, size)
        clash = _overlaps(corners, size)
        if not clash.any():
            break
        # What lies over another part of its chart becomes a chart of its own.
        label, axis = _part(label, axis, clash, normals, area, neighbours, attempt > 0)
    owner = np.full((size, size), -1, np.int32)
    weights = np.zeros((size, size, 3), np.float32)
    _native.raster_charts(np.ascontiguousarray(corners), owner, weights, size, size)
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


def _lean(label: np.ndarray, axis: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Cosine (m,) between each face and the axis of its chart."""
    return np.einsum("fi,fi->f", normals, axis[label])


def _adopt(
    label: np.ndarray, axis: np.ndarray, normals: np.ndarray, neighbours: np.ndarray, free: np.ndarray, limit: float
) -> np.ndarray:
    """Hand ``free`` faces to the neighbouring chart they fit best, in rounds, where their cosine is ``limit`` or more.

    Changes ``label`` in place; returns which faces are still free.
    """
    free = free.copy()
    while True:
        waiting = np.flatnonzero(free)
        around = neighbours[waiting]
        fit = np.einsum("fi,fci->fc", normals[waiting], axis[label[around]])
        fit[free[around]] = -1.0
        best = np.argmax(fit, 1)
        rows = np.arange(len(waiting))
        good = fit[rows, best] >= limit
        if not good.any():
            return free
        label[waiting[good]] = label[around[rows, best][good]]
        free[waiting[good]] = False


def _flatten(
    label: np.ndarray, normals: np.ndarray, area: np.ndarray, neighbours: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Connected charts (m,) and their axes (charts, 3): every face's cosine to its axis is at least STEEPEST."""
    for _ in range(3):
        label = _connected(label, neighbours)
        axis = _axes(label, normals, area)
        steep = _adopt(label, axis, normals, neighbours, _lean(label, axis, normals) < LEVEL, LEVEL)
        # What no neighbour can take is split off and flattened on its own.
        label = np.where(steep, len(axis) + label, label)
    label = _connected(label, neighbours)
    axis = _axes(label, normals, area)
    small = np.bincount(label)[label] < SMALL
    core = np.where(small, 0.0, area)
    _adopt(label, axis, normals, neighbours, small, STEEPEST)
    label = _connected(label, neighbours)
    alone = np.bincount(label, core) == 0
    return _singled(label, _axes(label, normals, np.where(alone[label], area, core)), normals)


def _singled(label: np.ndarray, axis: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Make every face that is still too steep a chart of its own."""
    steep = np.flatnonzero(_lean(label, axis, normals) < STEEPEST)
    label = label.copy()
    label[steep] = len(axis) + np.arange(len(steep))
    used, label = np.unique(label, return_inverse=True)
    return label, np.concatenate([axis, normals[steep]])[used]


def _part(
    label: np.ndarray,
    axis: np.ndarray,
    clash: np.ndarray,
    normals: np.ndarray,
    area: np.ndarray,
    neighbours: np.ndarray,
    singly: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Take the faces ``clash`` out of their charts: a connected patch a chart or, where ``singly``, a face a chart."""
    patch = np.where(clash, 1 + label, 0) if not singly else np.where(clash, 1 + np.arange(len(label)), 0)
    parts = _connected(patch, neighbours)
    parts, own = np.unique(np.where(clash, parts, -1), return_inverse=True)
    own_axis = _axes(own, normals, area)
    axis = np.concatenate([axis, own_axis])
    label, axis = _singled(np.where(clash, len(axis) - len(own_axis) + own, label), axis, normals)
    # What is left of a chart may have fallen apart; its pieces keep the axis.
    pieces = _connected(label, neighbours)
    _, first = np.unique(pieces, return_index=True)
    return pieces, axis[label[first]]


def _connected(label: np.ndarray, neighbours: np.ndarray) -> np.ndarray:
    return connected_components(_dual(neighbours, label[:, None] == label[neighbours]), directed=False)[1].astype(
        np.int64
    )


def _planes(axis: np.ndarray) -> np.ndarray:
    """For each chart axis two directions (charts, 2, 3) that span its plane, right-handed."""
    helper = np.where(np.abs(axis[:, 2:]) < 0.8, [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    right = np.cross(helper, axis)
    right /= np.maximum(np.linalg.norm(right, axis=1, keepdims=True), 1e-300)
    return np.stack([right, np.cross(axis, right)], 1)


def _align(flat: np.ndarray, label: np.ndarray, area: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """Turn every chart's corners (m, 3, 2) so that its long axis lies along u, one way or the other at random."""
    centres = flat.mean(1)
    middle = np.stack([_mean(label, centres[:, i], area) for i in range(2)], 1)
    x, y = (centres - middle[label]).T
    angle = 0.5 * np.arctan2(2 * _mean(label, x * y, area), _mean(label, x * x - y * y, area))
    angle = angle + np.pi * generator.integers(0, 2, len(angle)) + generator.uniform(-0.06, 0.06, len(angle))
    c, s = np.cos(angle)[label][:, None], np.sin(angle)[label][:, None]
    return np.stack([c * flat[..., 0] + s * flat[..., 1], c * flat[..., 1] - s * flat[..., 0]], -1)


def _pack(flat: np.ndarray, label: np.ndarray, size: int) -> np.ndarray:
    """Corners (m, 3, 2) in texels, y down: charts side by side on shelves, as large as they fit."""
    count = int(label.max()) + 1
    order = np.argsort(label, kind="stable")
    first = np.searchsorted(label[order], np.arange(count))
    low = np.minimum.reduceat(flat.min(1)[order], first)
    extent = np.maximum.reduceat(flat.max(1)[order], first) - low
    highest = np.lexsort((np.arange(count), -extent[:, 1]))
    small, large = 0.0, 4.0 * size / float(np.sqrt(extent.prod(1).sum()))
    for _ in range(14):
        scale = 0.5 * (small + large)
        if _shelves(extent[highest] * scale + GUTTER, size) is None:
            large = scale
        else:
            small = scale
    places = np.empty((count, 2))
    places[highest] = _shelves(extent[highest] * small + GUTTER, size)
    texels = (flat - low[label][:, None]) * small + places[label][:, None] + 0.5 * GUTTER
    return np.stack([texels[..., 0], size - texels[..., 1]], -1)


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
    """Which faces (m,) lie over others: without them no two overlap."""
    fine = size * OVERSAMPLING
    clash = np.zeros(len(corners), np.uint8)
    taken = np.zeros((fine, fine), np.uint8)
    _native.find_overlaps(np.ascontiguousarray(corners * OVERSAMPLING), taken, clash, fine, fine)
    return clash.astype(bool)
