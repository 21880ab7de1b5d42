"""Where on the surface every texel of the atlas lies."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg import _native
from unstructured_mg.synthesis.flow_surface import FlowSurface


@dataclass(frozen=True)
class Texels:
    """Surface points of texels, charts and margins around them, face by face: neighbours in memory are so in space.

    Attributes
    ----------
    height, width : of the image
    index : (t,) int64, row * width + column
    face : (t,) int32, face of the flow surface
    weights : (t, 2) float32, barycentric weights of corners 1 and 2
    inside : (t,) bool, True in charts, False in their margins
    """

    height: int
    width: int
    index: np.ndarray
    face: np.ndarray
    weights: np.ndarray
    inside: np.ndarray


def to_pixels(uv: np.ndarray, height: int, width: int) -> np.ndarray:
    """Pixel places (column, row; centres at half-integers, row 0 on top) of uvs (..., 2) with v upwards."""
    return np.ascontiguousarray(np.stack([uv[..., 0] * width, (1 - uv[..., 1]) * height], axis=-1))


def cover_texels(places: np.ndarray, height: int, width: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Which triangle covers each texel centre; the first where several do.

    places (m, 3, 2) float64 pixel corners. Returns owner (height, width) int32, -1 where none; weights
    (height, width, 2) float32 of corners 1 and 2; and how often a texel lay well inside a further triangle
    (overlapping charts).
    """
    owner = np.full((height, width), -1, np.int32)
    weights = np.zeros((height, width, 2), np.float32)
    twice = _native.raster_faces(np.ascontiguousarray(places, np.float64), len(places), height, width, owner, weights)
    return owner, weights, twice


def locate_texels(surface: FlowSurface, height: int, width: int, margin: int) -> Texels:
    """Locate all texels of charts, and those of a margin ``margin`` pixels wide around them.

    A texel of the margin lies where the surface goes on beyond the chart's rim: across the seam, on another chart. So
    filtering at a rim mixes true neighbours, and no seam shows.
    """
    places = to_pixels(surface.uv, height, width)
    covered, weights, _ = cover_texels(places, height, width)
    owner = np.full((height, width), -1, np.int32)
    rim = np.zeros((height, width, 4), np.float32)
    distance = np.full((height, width), np.inf, np.float32)
    _native.raster_margin(places, len(places), height, width, float(margin), covered, owner, rim, distance)
    outside = np.flatnonzero(owner.ravel() >= 0)
    beyond = rim.reshape(-1, 4)[outside].astype(np.float64)
    start = np.column_stack([1 - beyond[:, 0] - beyond[:, 1], beyond[:, :2]]).clip(0, 1)
    step = beyond[:, 2:] - beyond[:, :2]
    outside_face = owner.ravel()[outside]
    layout = surface.tracing.layout[outside_face]
    displacement = step[:, :1] * (layout[:, 1] - layout[:, 0]) + step[:, 1:] * (layout[:, 2] - layout[:, 0])
    # A face nearly flat in the atlas would throw its margin across the body.
    length = np.linalg.norm(displacement, axis=1, keepdims=True)
    farthest = 4 * np.sqrt(surface.tracing.areas.mean())
    displacement *= np.minimum(1, farthest / np.maximum(length, 1e-300))
    outside_face, outside_weights = surface.tracing.displace(outside_face, start, displacement)
    inside = np.flatnonzero(covered.ravel() >= 0)
    index = np.concatenate([inside, outside])
    face = np.concatenate([covered.ravel()[inside], outside_face])
    order = np.argsort(face, kind="stable")
    both = np.concatenate([weights.reshape(-1, 2)[inside], outside_weights[:, 1:].astype(np.float32)])
    is_inside = np.concatenate([np.ones(len(inside), bool), np.zeros(len(outside), bool)])
    return Texels(
        height,
        width,
        index[order].astype(np.int64),
        np.ascontiguousarray(face[order], np.int32),
        np.ascontiguousarray(both[order]),
        is_inside[order],
    )


def unbroken(surface: FlowSurface, texels: Texels) -> np.ndarray:
    """(height, width) bool: texels in charts whose eight neighbours in the image are their neighbours on the surface.

    Charts may touch in the image: two texels count as neighbours where they lie no farther apart than four times the
    median of all.
    """
    chosen = np.flatnonzero(texels.inside)
    place = np.full((texels.height, texels.width, 3), np.nan)
    place.reshape(-1, 3)[texels.index[chosen]] = at_texels(surface, texels, surface.vertices)[chosen]
    steps = [np.linalg.norm(np.diff(place, axis=axis), axis=2) for axis in (1, 0)]
    known = np.concatenate([step[np.isfinite(step)] for step in steps])
    farthest = 4 * np.median(known) if len(known) else 0.0
    # Whether each texel goes on to the right and below; comparing with NaN is False.
    right, below = np.zeros((2, texels.height, texels.width), bool)
    right[:, :-1], below[:-1] = steps[0] <= farthest, steps[1] <= farthest
    left, above = np.zeros_like(right), np.zeros_like(below)
    left[:, 1:], above[1:] = right[:, :-1], below[:-1]
    whole = right & below & left & above
    for onward in (below, above):
        whole[:, :-1] &= onward[:, 1:]
        whole[:, 1:] &= onward[:, :-1]
    whole[:, [0, -1]] = False
    return whole


def at_texels(surface: FlowSurface, texels: Texels, values: np.ndarray) -> np.ndarray:
    """Values (t, d) at texels of what is given at the surface's vertices (n, d), linear in faces."""
    corners = surface.tracing.faces[texels.face]
    second, third = texels.weights[:, :1].astype(np.float64), texels.weights[:, 1:].astype(np.float64)
    first = values[corners[:, 0]]
    return first + second * (values[corners[:, 1]] - first) + third * (values[corners[:, 2]] - first)
