"""Move both end signals along one flow and blend them, at every step of a transition (P section 6.3)."""

import numpy as np

from unstructured_mg import _native
from unstructured_mg.geometry.tracing import TracingSurface
from unstructured_mg.synthesis.flow import FlowSolver
from unstructured_mg.synthesis.flow_surface import FlowSurface
from unstructured_mg.synthesis.images import Image
from unstructured_mg.synthesis.texels import Texels, to_pixels


def advect_images(
    surface: FlowSurface, texels: Texels, corners: np.ndarray, start: Image, end: Image, steps: int
) -> np.ndarray:
    """Images ``(steps, height, width, 3) uint8`` between two.

    Step i of 1 .. steps, at l = i / (steps + 1), is ``(1 - l) start(gamma(-l)) + l end(gamma(1 - l))`` with gamma the
    streamline through the texel: one trace serves all steps. Texels off the surface stand still.

    Parameters
    ----------
    corners : (m, 3, 2) float64, the flow from start to end at face corners; metres
    start, end : the images at both ends, filled outside charts
    """
    shape = (texels.height, texels.width, 4)
    first, last = start.coefficients, end.coefficients
    if first.shape != shape or last.shape != shape:
        raise ValueError(f"start, end: expected shape {shape}, got {first.shape} and {last.shape}")
    images = np.empty((steps, *shape[:2], 3), np.uint8)
    background = np.ones(shape[0] * shape[1], bool)
    background[texels.index] = False
    background = np.flatnonzero(background)
    # Nothing shows it, and it is smooth: there coefficients are as good as texels, and one fill is as good as another.
    still = 0.5 * (first.reshape(-1, 4)[background, :3] + last.reshape(-1, 4)[background, :3])
    images.reshape(steps, -1, 3)[:, background] = still.clip(0, 255).astype(np.uint8)
    places = to_pixels(surface.uv, *shape[:2]).astype(np.float32)
    _native.advect_texels(
        *surface.tracing.tables, np.ascontiguousarray(corners, np.float64), places, len(texels.index), texels.face,
        texels.weights, texels.index, first, last, *shape[:2], steps, images,
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
