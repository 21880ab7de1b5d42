"""Which way a captured figure faces, so that its pictures show its face."""

import numpy as np


def facing(vertices: np.ndarray, faces: np.ndarray) -> float:
    """The azimuth (radians about +z, 0 along +x) that a standing figure most likely faces.

    A surface that is open at the back has a net normal, which points to the front. A closed one stands on feet, whose
    toes lie before the shins. Where neither says anything: -y, the front of y-up captures that look along +z.

    Parameters
    ----------
    vertices : (n, 3) float64, metres, z up
    faces : (m, 3) int32
    """
    corners = vertices[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    net = normal.sum(axis=0)
    if np.hypot(net[0], net[1]) > 0.1 * area.sum() > 0:
        return float(np.arctan2(net[1], net[0]))
    middle = corners.mean(axis=1)
    low, high = vertices[:, 2].min(), vertices[:, 2].max()
    height = (middle[:, 2] - low) / max(high - low, 1e-9)
    foot, shin = area * (height < 0.04), area * ((height > 0.07) & (height < 0.16))
    if foot.sum() > 0 and shin.sum() > 0:
        toes = foot @ middle[:, :2] / foot.sum() - shin @ middle[:, :2] / shin.sum()
        if np.hypot(*toes) > 0.01 * (high - low):
            return float(np.arctan2(toes[1], toes[0]))
    return -np.pi / 2
