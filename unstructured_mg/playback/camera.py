"""Cameras for pictures: where to stand so that one camera holds a whole series of meshes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Camera:
    """A pinhole or parallel camera with square pixels and its principal point in the middle of the picture.

    Attributes
    ----------
    position : (3,) float64, metres
    rotation : (3, 3) float64, rows: the camera's right, up and forward directions in the world
    scale : pixels per metre at depth 1 m (perspective: the focal length in pixels) or at any depth (parallel)
    height, width : pixels
    perspective : False for a parallel projection
    """

    position: np.ndarray
    rotation: np.ndarray
    scale: float
    height: int
    width: int
    perspective: bool = True

    def project(self, points: np.ndarray) -> np.ndarray:
        """Homogeneous picture coordinates of (n, 3) points: (n, 4) float64 ``x w, y w, z w, w``.

        ``x`` to the right and ``y`` down, in pixels from the picture's corner; ``z`` grows with depth and is linear in
        the picture; ``w`` is the depth in metres (perspective) or 1.
        """
        right, up, depth = self.rotation @ (points - self.position).T
        w = depth if self.perspective else np.ones(len(depth))
        z = -np.ones(len(depth)) if self.perspective else depth
        return np.stack([self.width / 2 * w + self.scale * right, self.height / 2 * w - self.scale * up, z, w], axis=1)


def view_rotation(azimuth: float, elevation: float) -> np.ndarray:
    """Rows right, up, forward of an upright camera that looks at the subject from ``azimuth``, ``elevation`` (radians).

    Azimuth 0 stands on the subject's +x side, pi/2 on its +y side; the elevation is above the horizon.
    """
    back = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], dtype=np.float64
    )
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    return np.stack([right, np.cross(back, right), -back])


def fit_camera(
    point_sets: Sequence[np.ndarray],
    *,
    height: int,
    width: int,
    azimuth: float,
    elevation: float = 0.0,
    field_of_view: float = np.radians(25.0),
    margin: float = 0.06,
) -> Camera:
    """The nearest upright camera that sees every point of every set.

    Parameters
    ----------
    point_sets : (n, 3) arrays, metres: for instance the vertices of all meshes of one contact sheet
    height, width : pixels
    azimuth, elevation : radians, as in `view_rotation`
    field_of_view : vertical, radians; 0 gives a parallel projection
    margin : share of the picture's width and height that stays free on each side

    Raises
    ------
    ValueError
        Without a point, or for a margin or field of view that leaves no picture.
    """
    if not 0 <= margin < 0.5:
        raise ValueError(f"margin: expected a share in 0 .. 0.5, got {margin}")
    if not 0 <= field_of_view < np.pi:
        raise ValueError(f"field_of_view: expected radians in 0 .. pi, got {field_of_view}")
    if sum(len(points) for points in point_sets) == 0:
        raise ValueError("point_sets: expected at least one point")
    rotation = view_rotation(azimuth, elevation)
    seen = np.concatenate([points @ rotation.T for points in point_sets])
    low, high = seen.min(axis=0), seen.max(axis=0)
    middle = (low + high) / 2
    # A subject without extent still gets a picture: of one millimetre.
    half_width, half_height = np.array([width, height]) / 2 * (1 - 2 * margin)
    if field_of_view == 0:
        extent = np.maximum(high - low, 1e-3) / 2
        scale = min(half_width / extent[0], half_height / extent[1])
        return Camera(rotation.T @ middle, rotation, float(scale), height, width, perspective=False)
    focal = height / 2 / np.tan(field_of_view / 2)
    offset = np.abs(seen - middle)
    # |x| focal / (distance + depth) must stay within half the picture, for every point.
    needed = np.maximum(offset[:, 0] * focal / half_width, offset[:, 1] * focal / half_height) - (seen - middle)[:, 2]
    distance = max(float(needed.max()), (high - low)[2] / 2 + 1e-3)
    position = rotation.T @ (middle - [0, 0, distance])
    return Camera(position, rotation, float(focal), height, width)
