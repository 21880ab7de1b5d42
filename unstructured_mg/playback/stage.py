"""The ground under a rendered figure: a faint grid that shows sliding feet, and a soft shadow that shows contact."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates

from unstructured_mg.playback.camera import Camera
from unstructured_mg.playback.render import Drawable, render

BACKDROP = (224, 227, 231)
# Metres: grid lines every half metre on a disc that fades out around the figure; size of a shadow's cell; the height at
# which the shadow has faded to a third.
GRID, RADIUS, CELL, FADE = 0.5, 2.0, 0.02, 0.12


@dataclass(frozen=True)
class Stage:
    """The ground as one camera sees it; only the shadow differs from figure to figure.

    Attributes
    ----------
    light : (height, width) float64, the share of the backdrop's light that the empty ground leaves
    floor : (height, width, 2) float64, metres: where on the floor each pixel looks
    visible : (height, width) bool, the pixels that look at the floor near the figure
    """

    light: np.ndarray
    floor: np.ndarray
    visible: np.ndarray

    @classmethod
    def of(cls, camera: Camera, centre: np.ndarray) -> "Stage":
        """The ground for ``camera``, with a grid that fades out around ``centre`` (2,)."""
        down, floor = _floor_points(camera)
        away = np.hypot(floor[..., 0] - centre[0], floor[..., 1] - centre[1])
        fade = np.where(down, np.clip(1 - away / RADIUS, 0, 1) ** 0.7, 0)
        line = np.maximum(_line_share(floor[..., 0]), _line_share(floor[..., 1]))
        return cls(1 - fade * (0.035 + 0.16 * line), floor, fade > 0)

    def under(self, figure: Drawable) -> np.ndarray:
        """The backdrop for a figure that stands on the floor at z = 0: (height, width, 3) uint8, to be drawn over.

        The shadow is soft and straight below the figure: the surface darkens the floor less, the higher it is.
        """
        light = self.light
        if self.visible.any():
            light = light * (
                1 - 0.7 * np.where(self.visible, _shadow(figure, self.floor[..., 0], self.floor[..., 1]), 0)
            )
        return np.rint(light[..., None] * np.array(BACKDROP, np.float64)).astype(np.uint8)


def _floor_points(camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Which pixels look at the floor, and where: (height, width) bool and (height, width, 2) metres."""
    right = (np.arange(camera.width) + 0.5 - camera.width / 2) / camera.scale
    up = (camera.height / 2 - np.arange(camera.height) - 0.5) / camera.scale
    aside = right[None, :, None] * camera.rotation[0] + up[:, None, None] * camera.rotation[1]
    if camera.perspective:
        ray, start = aside + camera.rotation[2], np.broadcast_to(camera.position, aside.shape)
    else:
        # A parallel camera stands infinitely far back.
        ray, start = np.broadcast_to(camera.rotation[2], aside.shape), camera.position + aside
    down = (ray[..., 2] < -1e-6) & ((start[..., 2] > 0) | (not camera.perspective))
    travelled = np.where(down, -start[..., 2] / np.where(down, ray[..., 2], 1.0), 0.0)
    return down, start[..., :2] + travelled[..., None] * ray[..., :2]


def _line_share(coordinate: np.ndarray) -> np.ndarray:
    """How much of each pixel a grid line of 12 mm covers, softened over the pixel's own footprint."""
    step = np.maximum(np.abs(np.gradient(coordinate, axis=0)) + np.abs(np.gradient(coordinate, axis=1)), 1e-9)
    off = np.abs(coordinate - GRID * np.rint(coordinate / GRID))
    return np.clip((0.006 + step / 2 - off) / step, 0, 1) * np.clip(0.012 / step, 0, 1)


def _shadow(figure: Drawable, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """How dark the floor is at each point, 0 to 1: the figure seen from straight below, its lowest parts darkest."""
    vertices = figure.vertices
    low, high = vertices[:, :2].min(axis=0) - 0.5, vertices[:, :2].max(axis=0) + 0.5
    width, height = np.ceil((high - low) / CELL).astype(int)
    below = np.rint(255 * np.exp(-np.maximum(vertices[:, 2], 0) / FADE)).astype(np.uint8)
    position = np.array([low[0] + width * CELL / 2, low[1] + height * CELL / 2, 0])
    upwards = Camera(position, np.diag([1.0, -1.0, 1.0]), 1 / CELL, int(height), int(width), perspective=False)
    seen = render(
        Drawable(vertices, figure.faces, colors=below[:, None].repeat(3, 1)), upwards, background=(0, 0, 0), shading=0
    )
    blocked = seen.image[..., 0] / 255
    dark = 0.6 * gaussian_filter(blocked, 1.5) + 0.4 * gaussian_filter(blocked, 6.0)
    at = np.stack([(y - low[1]) / CELL - 0.5, (x - low[0]) / CELL - 0.5])
    return np.clip(map_coordinates(dark, at, order=1, mode="constant"), 0, 1)
