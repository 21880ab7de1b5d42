"""One view for a whole series of pictures, so that what moves in them moves in the scene."""

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image

from unstructured_mg.geometry.components import significant_faces
from unstructured_mg.playback.camera import Camera, fit_camera, view_rotation
from unstructured_mg.playback.facing import facing
from unstructured_mg.playback.pictures import Picture
from unstructured_mg.playback.render import Drawable, render
from unstructured_mg.playback.stage import Stage

# A quarter off the figure's front, a little from above.
AZIMUTH_OFFSET, ELEVATION = np.radians(-22.0), np.radians(9.0)
# Of a cell, width over height: so far it takes the shape of what is to be seen.
NARROWEST, WIDEST = 0.42, 1.6
# The close view shows this much of the figures' upper end, in metres, or this share of their height where that is more.
CLOSE_METRES, CLOSE_SHARE = 0.36, 0.2
# Width of the close view, of its height.
CLOSE_WIDTH = 1.2
QUALITY = 84


@dataclass(frozen=True)
class Framing:
    """From where a series of meshes is seen.

    Attributes
    ----------
    points : what must be in the picture: for each mesh (n, 3) float64
    azimuth : of the camera, radians
    centre : (2,) float64, the middle of all meshes on the floor
    aspect : width over height of a cell that the whole series fills
    """

    points: tuple[np.ndarray, ...]
    azimuth: float
    centre: np.ndarray
    aspect: float

    @classmethod
    def of(cls, drawables: Sequence[Drawable]) -> "Framing":
        """See all meshes, the first of them from its front. Debris counts for nothing."""
        points = tuple(_solid(each.vertices, each.faces) for each in drawables)
        azimuth = facing(drawables[0].vertices, drawables[0].faces) + AZIMUTH_OFFSET
        centre = np.mean([(each.min(axis=0) + each.max(axis=0))[:2] / 2 for each in points], axis=0)
        probe = fit_camera(points, height=1000, width=1000, azimuth=azimuth, elevation=ELEVATION, margin=0.0)
        picture = np.concatenate([probe.project(each) for each in points])
        width, height = np.ptp(picture[:, 0] / picture[:, 3]), np.ptp(picture[:, 1] / picture[:, 3])
        return cls(points, azimuth, centre, float(np.clip(1.1 * width / max(height, 1e-9), NARROWEST, WIDEST)))

    def camera(self, largest: tuple[int, int]) -> Camera:
        """A camera on the whole series, whose pictures fit into ``largest`` (height, width) pixels."""
        height = round(min(largest[0], largest[1] / self.aspect))
        return self._fit(self.points, height, round(height * self.aspect))

    def close_camera(self, height: int, width: int) -> Camera:
        """A camera on the figures' upper end: head and shoulders where they stand upright."""
        aside = CLOSE_WIDTH / 2 * view_rotation(self.azimuth, ELEVATION)[0]
        corners = []
        for each in self.points:
            low, high = each[:, 2].min(), each[:, 2].max()
            reach = max(CLOSE_METRES, CLOSE_SHARE * (high - low))
            # The middle of what is up there, not of its bounds: a raised arm may leave the picture.
            middle = each[each[:, 2] >= high - reach].mean(axis=0)
            corners += [[*(middle + side * reach * aside)[:2], z] for side in (-1, 1) for z in (high - reach, high)]
        return self._fit([np.array(corners)], height, width)

    def draw(self, drawables: Sequence[Drawable], camera: Camera) -> list[np.ndarray]:
        """A picture of each mesh on the stage."""
        stage = Stage.of(camera, self.centre)
        return [render(each, camera, background=stage.under(each)).image for each in drawables]

    def _fit(self, points: Sequence[np.ndarray], height: int, width: int) -> Camera:
        return fit_camera(points, height=height, width=width, azimuth=self.azimuth, elevation=ELEVATION)


def _solid(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    return vertices[np.unique(faces[significant_faces(vertices, faces)])]


def encode(image: np.ndarray) -> Picture:
    """A (height, width, 3) uint8 image as JPEG."""
    data = io.BytesIO()
    Image.fromarray(image).save(data, "JPEG", quality=QUALITY, optimize=True)
    return Picture(data.getvalue(), image.shape[1], image.shape[0])
