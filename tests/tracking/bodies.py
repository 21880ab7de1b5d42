"""Small analytic bodies that the tracking tests share."""

import numpy as np


def tube(radius: float, length: float, around: int, along: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed, round-capped tube along x, outward oriented: vertices (n, 3), faces (m, 3) int32."""
    half = 0.5 * length
    arc = np.linspace(0, np.pi / 2, 6)[1:]
    profile = np.concatenate(
        [
            np.stack([-half - radius * np.sin(arc[::-1][1:]), radius * np.cos(arc[::-1][1:])], 1),
            np.stack([np.linspace(-half, half, along), np.full(along, radius)], 1),
            np.stack([half + radius * np.sin(arc[:-1]), radius * np.cos(arc[:-1])], 1),
        ]
    )
    angle = 2 * np.pi * np.arange(around) / around
    rings = np.stack(
        [
            np.repeat(profile[:, 0], around),
            np.outer(profile[:, 1], np.cos(angle)).ravel(),
            np.outer(profile[:, 1], np.sin(angle)).ravel(),
        ],
        axis=1,
    )
    vertices = np.concatenate([rings, [[-half - radius, 0, 0], [half + radius, 0, 0]]])
    faces = []
    next_around = (np.arange(around) + 1) % around
    for ring in range(len(profile) - 1):
        a, b = ring * around + np.arange(around), ring * around + next_around
        faces += [np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)]
    last = (len(profile) - 1) * around
    start, end = len(rings), len(rings) + 1
    faces.append(np.stack([np.full(around, start), next_around, np.arange(around)], 1))
    faces.append(np.stack([np.full(around, end), last + np.arange(around), last + next_around], 1))
    faces = np.concatenate(faces).astype(np.int32)
    corner = vertices[faces]
    if np.einsum("fx,fx->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) < 0:
        faces = faces[:, ::-1].copy()
    return vertices, faces


def figure(around: int, along: int) -> tuple[np.ndarray, np.ndarray]:
    """A tube of human size, standing, with a cross-section that tells directions apart."""
    vertices, faces = tube(0.15, 1.4, around, along)
    angle = np.arctan2(vertices[:, 2], vertices[:, 1])
    swell = 1 + 0.25 * np.cos(angle) + 0.12 * np.sin(2 * angle) + 0.1 * np.sin(7 * vertices[:, 0])
    vertices = np.stack([vertices[:, 1] * swell, vertices[:, 2] * swell, vertices[:, 0] + 0.9], axis=1)
    corner = vertices[faces]
    if np.einsum("fx,fx->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) < 0:
        faces = faces[:, ::-1].copy()
    return vertices, faces


def bend(points: np.ndarray, angle: float, low: float = 0.5, high: float = 1.3) -> np.ndarray:
    """Bend a standing body about the y axis by ``angle`` radians between two heights; lengths on the axis are kept."""
    z = points[:, 2]
    turn = angle * np.clip((z - low) / (high - low), 0, 1)
    radius = (high - low) / angle
    inside = np.clip(z, low, high)
    phi = angle * (inside - low) / (high - low)
    centre_x, centre_z = radius * (1 - np.cos(phi)), low + radius * np.sin(phi)
    beyond = z - inside
    x = centre_x + points[:, 0] * np.cos(turn) + beyond * np.sin(turn)
    height = centre_z - points[:, 0] * np.sin(turn) + beyond * np.cos(turn)
    return np.stack([x, points[:, 1], height], axis=1)
