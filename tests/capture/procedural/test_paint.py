"""The paint: a function of the place alone, with the parts where they belong."""

import numpy as np
import pytest

from unstructured_mg.capture.procedural.body import reference_body
from unstructured_mg.capture.procedural.paint import CORAL, CREAM, HAIR, JEANS, SHIRT, SHOE, SKIN, SOLE, paint


@pytest.mark.parametrize(
    "place, color",
    [
        ((0.0, -0.10, 1.67), SKIN),  # forehead
        ((0.0, 0.12, 1.68), HAIR),
        ((0.10, -0.10, 1.17), SHIRT),
        ((0.0, -0.11, 1.105), CREAM),
        ((0.0, -0.11, 1.075), CORAL),
        ((0.12, -0.06, 0.65), JEANS),
        ((0.14, 0.03, 0.055), SHOE),
        ((0.15, -0.17, 0.03), SOLE),
        ((0.45, 0.0, 1.145), SKIN),  # forearm
    ],
)
def test_parts_have_their_colours(place, color):
    painted = paint(np.array([place]), np.ones(1))[0].astype(float)
    palette = np.array([SKIN, HAIR, SHIRT, CREAM, CORAL, JEANS, SHOE, SOLE])
    assert (palette[np.argmin(np.linalg.norm(palette - painted, axis=1))] == color).all()


def test_colours_depend_on_the_place_alone():
    points = reference_body().vertices[::7]
    shade = np.full(len(points), 0.8)
    whole = paint(points, shade)
    order = np.random.default_rng(0).permutation(len(points))
    assert (paint(points[order], shade[order]) == whole[order]).all()
    assert (np.concatenate([paint(points[:100], shade[:100]), paint(points[100:], shade[100:])]) == whole).all()


def test_shade_darkens():
    points = reference_body().vertices[::50]
    assert (paint(points, np.zeros(len(points))) <= paint(points, np.ones(len(points)))).all()
