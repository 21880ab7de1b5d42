"""One colour map for all pictures: dark blue over teal to pale yellow, even steps of lightness."""

import numpy as np

# Oklab (Ottosson 2020): lightness, chroma and hue in degrees at 0, 1/4, ... 1; the lightness is a straight line.
_ANCHORS = np.array(
    [[0.20, 0.060, 285.0], [0.385, 0.105, 258.0], [0.57, 0.095, 215.0], [0.755, 0.120, 160.0], [0.94, 0.115, 105.0]]
)


def _oklab_to_srgb(lab: np.ndarray) -> np.ndarray:
    """(..., 3) Oklab to sRGB bytes, clipped to the gamut."""
    roots = lab @ np.array(
        [
            [1.0, 1.0, 1.0],
            [0.3963377774, -0.1055613458, -0.0894841775],
            [0.2158037573, -0.0638541728, -1.2914855480],
        ]
    )
    linear = roots**3 @ np.array(
        [
            [4.0767416621, -1.2684380046, -0.0041960863],
            [-3.3077115913, 2.6097574011, -0.7034186147],
            [0.2309699292, -0.3413193965, 1.7076147010],
        ]
    )
    linear = np.clip(linear, 0, 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * encoded).astype(np.uint8)


def _table() -> np.ndarray:
    at = np.linspace(0, len(_ANCHORS) - 1, 256)
    lightness, chroma, hue = (np.interp(at, np.arange(len(_ANCHORS)), column) for column in _ANCHORS.T)
    turn = np.radians(hue)
    return _oklab_to_srgb(np.stack([lightness, chroma * np.cos(turn), chroma * np.sin(turn)], axis=1))


COLORS = _table()
"""(256, 3) uint8 sRGB, from 0 to 1."""


def color_map(values: np.ndarray) -> np.ndarray:
    """Colours (..., 3) uint8 of values in 0..1; values outside are clipped, NaN is mid grey."""
    missing = np.isnan(values)
    index = np.rint(255 * np.clip(np.where(missing, 0, values), 0, 1)).astype(np.int64)
    return np.where(missing[..., None], np.uint8(128), COLORS[index])


def hex_color(value: float) -> str:
    """A value in 0..1 as ``#rrggbb``."""
    return "#" + bytes(color_map(np.array(value, np.float64))).hex()
