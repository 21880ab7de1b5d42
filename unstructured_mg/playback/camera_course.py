"""Where the camera of a video is at every frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from unstructured_mg.geometry.components import significant_faces
from unstructured_mg.playback.camera import Camera, fit_camera, view_rotation
from unstructured_mg.playback.facing import facing

# A quarter off the figure's front, a little from above; one turn of an orbit; how slowly its centre follows the figure.
AZIMUTH_OFFSET, ELEVATION, TURN_SECONDS, FOLLOW_SECONDS = np.radians(-22.0), np.radians(9.0), 12.0, 0.75
# Width over height of a picture.
NARROWEST, WIDEST = 9 / 16, 16 / 9
FIELD_OF_VIEW = np.radians(25.0)


@dataclass(frozen=True)
class Figure:
    """What a camera must know of a frame, debris apart: ``low`` and ``high`` (3,) metres in its own place, and where it
    faces (azimuth, radians).
    """

    low: np.ndarray
    high: np.ndarray
    azimuth: float


@dataclass(frozen=True)
class View:
    """A frame's camera, and around which place (2,), metres, it shows the ground."""

    camera: Camera
    centre: np.ndarray


def measure_figure(vertices: np.ndarray, faces: np.ndarray) -> Figure:
    """Bounds and front of a mesh: (n, 3) float64 metres, z up, and (m, 3) int32."""
    solid = vertices[np.unique(faces[significant_faces(vertices, faces)])]
    return Figure(solid.min(axis=0), solid.max(axis=0), facing(vertices, faces))


def fixed_course(figures: Sequence[Figure], worlds: Sequence[np.ndarray], height: int) -> list[View]:
    """One camera that sees the whole walk, before the first frame's figure; pictures have even sides.

    ``worlds`` are (4, 4), metres, z up; ``height`` in pixels.
    """
    corners = _corners(figures, worlds).reshape(-1, 3)
    azimuth = figures[0].azimuth + _yaw(worlds[0]) + AZIMUTH_OFFSET
    camera = _fit([corners], height, azimuth)
    return [View(camera, (corners.min(axis=0) + corners.max(axis=0))[:2] / 2)] * len(figures)


def orbit_course(figures: Sequence[Figure], worlds: Sequence[np.ndarray], height: int, fps: float) -> list[View]:
    """A camera that goes around the figure and follows it smoothly, always as far away as the widest frame needs.

    It sees every frame's upright cylinder about the followed place: no limb leaves the picture on any side.
    """
    corners = _corners(figures, worlds)
    middles = (corners.min(axis=1) + corners.max(axis=1)) / 2
    centres = gaussian_filter1d(middles[:, :2], FOLLOW_SECONDS * fps, axis=0, mode="nearest")
    away = corners[..., :2] - centres[:, None]
    radius = np.hypot(away[..., 0], away[..., 1]).max()
    low, high = corners[..., 2].min(), corners[..., 2].max()
    angle = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    ring = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    cylinder = np.concatenate([np.column_stack([ring, np.full(len(ring), z)]) for z in (low, high)])
    start = figures[0].azimuth + _yaw(worlds[0]) + AZIMUTH_OFFSET
    first = _fit([cylinder], height, start)
    distance = float(first.position @ -first.rotation[2])
    offset = first.position + distance * first.rotation[2]
    views = []
    for number, centre in enumerate(centres):
        rotation = view_rotation(start + 2 * np.pi * number / (TURN_SECONDS * fps), ELEVATION)
        position = np.array([*centre, 0.0]) + _turned(offset, number / (TURN_SECONDS * fps)) - distance * rotation[2]
        views.append(View(Camera(position, rotation, first.scale, first.height, first.width), centre))
    return views


def _turned(point: np.ndarray, turns: float) -> np.ndarray:
    c, s = np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns)
    return np.array([c * point[0] - s * point[1], s * point[0] + c * point[1], point[2]])


def _corners(figures: Sequence[Figure], worlds: Sequence[np.ndarray]) -> np.ndarray:
    """(frames, 8, 3) corners of the figures' bounds, in the world."""
    pick = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(-1, 3)
    bounds = np.stack([[figure.low, figure.high] for figure in figures])
    own = bounds[:, pick, np.arange(3)]
    matrices = np.stack(worlds)
    return own @ matrices[:, :3, :3].transpose(0, 2, 1) + matrices[:, None, :3, 3]


def _yaw(world: np.ndarray) -> float:
    return float(np.arctan2(world[1, 0], world[0, 0]))


def _fit(points: Sequence[np.ndarray], height: int, azimuth: float) -> Camera:
    """A camera whose picture is ``height`` pixels high, made even, and as wide as what is to be seen wants."""
    probe = fit_camera(points, height=1000, width=1000, azimuth=azimuth, elevation=ELEVATION, margin=0.0)
    seen = np.concatenate([probe.project(each) for each in points])
    width, tall = np.ptp(seen[:, 0] / seen[:, 3]), np.ptp(seen[:, 1] / seen[:, 3])
    aspect = float(np.clip(1.1 * width / max(tall, 1e-9), NARROWEST, WIDEST))
    even = max(2, height // 2 * 2)
    return fit_camera(
        points,
        height=even,
        width=max(2, round(even * aspect / 2) * 2),
        azimuth=azimuth,
        elevation=ELEVATION,
        field_of_view=FIELD_OF_VIEW,
    )
