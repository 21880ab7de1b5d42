"""Move both end signals along one flow and blend them, at every step of a transition (P section 6.3)."""

import numpy as np

from unstructured_mg import _native
from unstructured_mg.geometry.tracing import TracingSurface
from unstructured_mg.synthesis.flow import FlowSolver
from unstructured_mg.synthesis.flow_surface import FlowSurface
from unstructured_mg.synthesis.texels import Texels, to_pixels


def advect_images(
    surface: FlowSurface, texels: Texels, corners: np.ndarray, start: np.ndarray, end: np.ndarray, steps: int
) -> np.ndarray:
    """Images ``(steps, height, width, 3) uint8`` between two.

    Step i of 1 .. steps, at l = i / (steps + 1), is ``(1 - l) start(gamma(-l)) + l end(gamma(1 - l))`` with gamma the
    streamline through the texel: one trace serves all steps. Texels off the surface are cross-faded.

    Parameters
    ----------
    corners : (m, 3, 2) float64, the flow from start to end at face corners; metres
    start, end : (height, width, 4) float32, sRGB 0..255, filled outside charts
    """
    shape = (texels.height, texels.width, 4)
    if start.shape != shape or end.shape != shape:
        raise ValueError(f"start, end: expected shape {shape}, got {start.shape} and {end.shape}")
    images = np.empty((steps, *shape[:2], 3), np.uint8)
    background = np.ones(shape[0] * shape[1], bool)
    background[texels.index] = False
    flat = images.reshape(steps, -1, 3)
    first, last = start.reshape(-1, 4)[background, :3], end.reshape(-1, 4)[background, :3]
    for i in range(steps):
        share = np.float32((i + 1) / (steps + 1))
        flat[i, background] = ((1 - share) * first + share * last + 0.5).clip(0, 255)
    places = to_pixels(surface.uv, *shape[:2]).astype(np.float32)
    _native.advect_texels(
        *surface.tracing.tables, np.ascontiguousarray(corners, np.float64), places, len(texels.index), texels.face,
        texels.weights, texels.index, np.ascontiguousarray(start, np.float32), np.ascontiguousarray(end, np.float32),
        *shape[:2], steps, images,
    )  # fmt: skip
    return images


def advect_vertices(
    solver: FlowSolver, corners: np.ndarray, start: np.ndarray, end: np.ndarray, steps: int
) -> np.ndarray:
    """The same for colours at vertices: start, end (n, 3) in 0..255 to ``(steps, n, 3) uint8``."""
    tracing: TracingSurface = solver.tracing
    part = steps / (steps + 1)
    back_faces, back_weights = solver.paths(corners, -part, steps)
    front_faces, front_weights = solver.paths(corners, part, steps)
    colors = np.empty((steps, len(start), 3), np.uint8)
    for i in range(steps):
        share = (i + 1) / (steps + 1)
        first = np.einsum("pi,pic->pc", back_weights[i], start[tracing.faces[back_faces[i]]])
        last = np.einsum("pi,pic->pc", front_weights[steps - 1 - i], end[tracing.faces[front_faces[steps - 1 - i]]])
        colors[i] = ((1 - share) * first + share * last + 0.5).clip(0, 255)
    return colors
