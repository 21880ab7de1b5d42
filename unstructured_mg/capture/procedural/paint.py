"""What the procedural figure is painted with: colours as a function of the place on the resting body."""

import numpy as np

from unstructured_mg.capture.procedural.body import (
    CUFF,
    SLEEVE_END,
    hair_coordinate,
    hem_height,
    neck_coordinate,
    sleeve_coordinate,
)
from unstructured_mg.capture.procedural.skeleton import INDEX, REST

SKIN = np.array([226, 172, 138], np.float32)
HAIR = np.array([92, 52, 30], np.float32)
SHIRT = np.array([32, 128, 140], np.float32)
CREAM = np.array([246, 232, 200], np.float32)
CORAL = np.array([236, 98, 66], np.float32)
JEANS = np.array([52, 66, 112], np.float32)
THREAD = np.array([212, 160, 88], np.float32)
SHOE = np.array([206, 58, 52], np.float32)
SOLE = np.array([244, 240, 232], np.float32)

EDGE = 0.0030  # metres over which one colour turns into the next: about a texel of the trunk at 512 x 512


def _over(colors: np.ndarray, color: np.ndarray, cover: np.ndarray) -> None:
    colors += (color - colors) * cover[:, None]


def _edge(signed: np.ndarray, width: float = EDGE) -> np.ndarray:
    """1 where ``signed`` (metres) is positive, 0 where negative, a ramp of ``width`` between."""
    return np.clip(signed / width + 0.5, 0.0, 1.0)


def _band(value: np.ndarray, centre: float, half: float) -> np.ndarray:
    return _edge(half - np.abs(value - centre))


def _segment(x: np.ndarray, z: np.ndarray, a: tuple[float, float], b: tuple[float, float]) -> np.ndarray:
    """Distance to a drawn line."""
    dx, dz = b[0] - a[0], b[1] - a[1]
    t = np.clip(((x - a[0]) * dx + (z - a[1]) * dz) / (dx * dx + dz * dz), 0, 1)
    return np.hypot(x - a[0] - t * dx, z - a[1] - t * dz)


def _noise(points: np.ndarray, frequency: float) -> np.ndarray:
    """Smooth wavy values in -1..1, the same for the same point."""
    x, y, z = (points[:, i] * np.float32(frequency) for i in range(3))
    return (
        np.sin(x + 1.7 * np.sin(0.9 * y + 0.3)) * np.cos(1.1 * y + 1.3 * np.sin(0.8 * z)) + np.sin(1.3 * z + 1.1 * x)
    ) * 0.5


def paint(points: np.ndarray, shade: np.ndarray) -> np.ndarray:
    """Colours (p, 3) uint8, sRGB, of material points.

    ``points`` (p, 3) are places on the resting body in metres, ``shade`` (p,) in 0..1 how open each lies to the sky.
    """
    points = points.astype(np.float32)
    x, y, z = points.T
    colors = np.empty((len(points), 3), np.float32)
    arm = sleeve_coordinate(points)
    outer = np.abs(x) > 0.3
    hem = hem_height(points)
    head = (z > 1.475) & ~outer
    bare = (neck_coordinate(points) > 0) | (arm > SLEEVE_END)
    legs = ~outer & (z < hem)
    shoes = legs & (z < CUFF)
    trousers = legs & ~shoes
    shirt = ~bare & ~legs & ~(outer & (arm > SLEEVE_END))

    colors[:] = SKIN
    for part, brush in ((head, _head), (shirt, _shirt), (trousers, _trousers), (shoes, _shoes), (outer & bare, _hand)):
        chosen = np.flatnonzero(part)
        if len(chosen):
            colors[chosen] = brush(points[chosen])
    light = 0.62 + 0.38 * np.clip(shade, 0, 1)
    return np.clip(np.round(colors * light.astype(np.float32)[:, None]), 0, 255).astype(np.uint8)


def _plain(points: np.ndarray, color: np.ndarray) -> np.ndarray:
    return np.broadcast_to(color, (len(points), 3)).copy()


def _head(points: np.ndarray) -> np.ndarray:
    x, y, z = points.T
    colors = _plain(points, SKIN)
    colors *= (1 + 0.012 * _noise(points, 90))[:, None]
    front = y < -0.02
    side = np.abs(x)
    soft = 0.0016  # the face has twice the texels of the trunk
    # Cheeks, lips, eyes under their lids, brows.
    blush = np.exp(-((side - 0.048) ** 2 + (z - 1.588) ** 2) / 0.017**2)
    _over(colors, np.array([232, 128, 108], np.float32), 0.42 * front * blush)
    mouth = z - 1.5615 - 7.5 * x * x
    corner = _edge(0.029 - side, soft)
    _over(
        colors,
        np.array([206, 104, 96], np.float32),
        front * _edge(0.0062 - np.abs(mouth + 0.001) - 6 * x * x, soft) * corner,
    )
    _over(colors, np.array([128, 40, 44], np.float32), front * _edge(0.0019 - np.abs(mouth), soft) * corner)
    eye_x, eye_z = side - 0.0335, z - 1.632
    white = np.hypot(eye_x / 1.3, eye_z) - 0.0112
    lid = eye_z - 0.0072 + 14 * eye_x * eye_x
    opened = front * _edge(-lid, soft)
    _over(colors, np.array([176, 118, 92], np.float32), front * _edge(0.0018 - white, soft))
    _over(colors, np.array([248, 247, 243], np.float32), opened * _edge(-white, soft))
    iris = np.hypot(eye_x, eye_z + 0.0006)
    _over(colors, np.array([62, 100, 70], np.float32), opened * _edge(0.0074 - iris, soft))
    _over(colors, np.array([22, 20, 24], np.float32), opened * _edge(0.0040 - iris, soft))
    glint = np.hypot(side - 0.0335 - np.sign(x) * 0.0026, eye_z - 0.0022)
    _over(colors, np.array([255, 255, 255], np.float32), opened * _edge(0.0020 - glint, soft))
    lash = _edge(0.0013 - np.abs(lid), soft) * _edge(0.0155 - np.abs(eye_x), soft)
    _over(colors, np.array([62, 36, 26], np.float32), front * lash)
    brow = z - 1.6560 + 9.0 * (side - 0.034) ** 2
    _over(colors, HAIR * 0.8, front * _edge(0.0030 - np.abs(brow), soft) * _edge(0.0175 - np.abs(side - 0.034), soft))
    strands = (
        1 + 0.16 * np.sin(230 * x + 90 * y + 4 * np.sin(40 * z)) * np.sin(60 * z + 35 * y) + 0.10 * _noise(points, 60)
    )
    hair = HAIR * strands[:, None]
    scalp = _edge(hair_coordinate(points) + 0.002, 0.004) * _edge(z - 1.535)
    return colors + (hair - colors) * scalp[:, None]


def _hand(points: np.ndarray) -> np.ndarray:
    colors = _plain(points, SKIN)
    wrist = REST[INDEX["left_wrist"]]
    mirrored = np.stack([np.abs(points[:, 0]), points[:, 1], points[:, 2]], 1)
    way = wrist - REST[INDEX["left_elbow"]]
    along = np.einsum("pi,i->p", mirrored - wrist, way / np.linalg.norm(way))
    # A wrist watch on the left.
    left = points[:, 0] > 0
    _over(colors, np.array([40, 42, 50], np.float32), left * _band(along, -0.022, 0.011))
    _over(colors, np.array([236, 196, 84], np.float32), left * _band(along, -0.022, 0.0022))
    colors *= (1 + 0.014 * _noise(points, 80))[:, None]
    return colors


def _digit(
    x: np.ndarray, z: np.ndarray, strokes: tuple[tuple[tuple[float, float], tuple[float, float]], ...]
) -> np.ndarray:
    return np.min([_segment(x, z, a, b) for a, b in strokes], 0)


def _shirt(points: np.ndarray) -> np.ndarray:
    x, y, z = points.T
    colors = _plain(points, SHIRT)
    arm = sleeve_coordinate(points)
    sleeve = np.abs(x) > 0.205
    trunk = ~sleeve
    for centre, color in ((1.105, CREAM), (1.075, CORAL), (1.045, CREAM)):
        _over(colors, color, trunk * _band(z, centre, 0.0085))
    for centre, color in ((0.112, CREAM), (0.136, CORAL)):
        _over(colors, color, sleeve * _band(arm, centre, 0.0075))
    front, back = trunk & (y < 0), trunk & (y > 0.02)
    # A sun on the chest.
    u, w = x, z - 1.235
    radius, angle = np.hypot(u, w), np.arctan2(w, u)
    rays = 0.050 + 0.012 * np.cos(8 * angle)
    _over(colors, CREAM, front * _edge(0.066 - radius))
    _over(colors, CORAL, front * _edge(rays - radius))
    _over(colors, np.array([255, 206, 84], np.float32), front * _edge(0.031 - radius))
    _over(colors, np.array([70, 44, 34], np.float32), front * _edge(0.0042 - np.hypot(np.abs(u) - 0.011, w - 0.007)))
    _over(
        colors, np.array([70, 44, 34], np.float32), front * _edge(0.0022 - np.abs(radius - 0.018)) * _edge(-w - 0.004)
    )
    # 27 on the back, as seen from behind.
    u = -x
    two = _digit(
        u,
        z,
        (
            ((-0.062, 1.29), (-0.014, 1.29)),
            ((-0.014, 1.29), (-0.014, 1.235)),
            ((-0.014, 1.235), (-0.062, 1.18)),
            ((-0.062, 1.18), (-0.012, 1.18)),
        ),
    )
    seven = _digit(u, z, (((0.014, 1.29), (0.064, 1.29)), ((0.064, 1.29), (0.03, 1.18))))
    _over(colors, CREAM, back * _edge(0.0095 - np.minimum(two, seven)))
    # Hem, collar, sleeve ends, side seams, weave.
    dark = SHIRT * 0.72
    _over(colors, CREAM, _edge(neck_coordinate(points) + 0.009))
    _over(colors, dark, trunk * _band(z - hem_height(points), 0.014, 0.0014))
    _over(colors, dark, sleeve * _band(arm, SLEEVE_END - 0.012, 0.0014))
    _over(colors, dark, trunk * _band(y, 0.008, 0.0013) * (np.abs(x) > 0.1))
    colors *= (1 + 0.02 * np.sin(900 * z) * np.sin(900 * x + 900 * y) + 0.025 * _noise(points, 38))[:, None]
    return colors


def _trousers(points: np.ndarray) -> np.ndarray:
    x, y, z = points.T
    colors = _plain(points, JEANS)
    side = np.abs(x)
    left_leg = REST[INDEX["left_hip"]], REST[INDEX["left_ankle"]]
    t = np.clip((z - left_leg[0][2]) / (left_leg[1][2] - left_leg[0][2]), 0, 1)
    centre_x = left_leg[0][0] + t * (left_leg[1][0] - left_leg[0][0])
    # Worn knees and thighs.
    worn = np.exp(-(((z - 0.53) / 0.10) ** 2)) + 0.7 * np.exp(-(((z - 0.74) / 0.12) ** 2))
    _over(
        colors,
        np.array([112, 130, 172], np.float32),
        (y < 0) * 0.45 * worn * np.exp(-(((side - centre_x) / 0.045) ** 2)),
    )
    outside = side > centre_x
    for offset, color, half in ((0.0, JEANS * 0.55, 0.0016), (0.006, THREAD, 0.0009)):
        _over(colors, color, outside * _band(y, 0.004 + offset, half))
        _over(colors, color, ~outside * (z < 0.80) * _band(y, 0.004 + offset, half))
    _over(colors, THREAD, _band(z, CUFF + 0.022, 0.0011))
    pocket = _segment(side, z, (0.07, 0.93), (0.145, 0.865))
    _over(colors, THREAD, (y < 0) * _edge(0.0013 - pocket))
    fly = _segment(x, z, (0.012, 0.94), (0.012, 0.86))
    _over(colors, THREAD, (y < 0) * _edge(0.0012 - fly))
    u, w = side - 0.082, z - 0.87
    patch = np.maximum(np.abs(u) - 0.048, np.where(w > 0, w - 0.05, -w - 0.05 + 0.5 * np.abs(u)))
    _over(colors, JEANS * 0.8, (y > 0.03) * _edge(-patch))
    _over(colors, THREAD, (y > 0.03) * _edge(0.0012 - np.abs(patch + 0.004)))
    colors *= (1 + 0.03 * np.sin(1100 * z + 700 * x) + 0.04 * _noise(points, 45))[:, None]
    return colors


def _shoes(points: np.ndarray) -> np.ndarray:
    x, y, z = points.T
    colors = _plain(points, SHOE)
    side = np.abs(x) - 0.147
    _over(colors, SOLE, _edge(0.024 - z - 0.004 * (y < -0.14)))
    _over(colors, SHOE * 0.6, _band(z, 0.013, 0.0014))
    _over(colors, SOLE, _edge(-y - 0.128) * _edge(0.062 - z))
    for i in range(4):
        place = -0.100 + 0.021 * i
        _over(colors, SOLE, _band(y + 0.35 * np.abs(side), place, 0.0026) * _edge(0.024 - np.abs(side)) * (z > 0.05))
    _over(colors, SHOE * 0.65, _edge(z - 0.086))
    stripe = _segment(y, z, (-0.03, 0.03), (0.015, 0.07))
    _over(colors, SOLE, (np.abs(side) > 0.026) * _edge(0.005 - stripe))
    return colors
