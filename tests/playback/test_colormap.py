import numpy as np

from unstructured_mg.playback.colormap import COLORS, color_map, hex_color


def cie_lightness(colors):
    """L* of sRGB bytes (CIE 15, IEC 61966-2-1)."""
    share = colors / 255
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    y = linear @ [0.2126, 0.7152, 0.0722]
    return np.where(y > (6 / 29) ** 3, 116 * np.cbrt(y) - 16, y * (29 / 3) ** 3)


def test_lightness_rises_evenly():
    lightness = cie_lightness(COLORS[::15].astype(float))
    steps = np.diff(lightness)
    assert steps.min() > 0.6 * steps.mean()
    assert steps.max() < 1.5 * steps.mean()
    assert lightness[0] < 12 and lightness[-1] > 90


def test_values_outside_are_clipped_and_missing_ones_grey():
    colors = color_map(np.array([[-1.0, 0.0, 1.0], [2.0, np.nan, 0.5]]))
    assert (colors[0, 0] == COLORS[0]).all() and (colors[0, 1] == COLORS[0]).all()
    assert (colors[0, 2] == COLORS[255]).all() and (colors[1, 0] == COLORS[255]).all()
    assert (colors[1, 1] == 128).all()
    assert (colors[1, 2] == COLORS[128]).all()
    assert hex_color(1.0) == "#{:02x}{:02x}{:02x}".format(*COLORS[255])
