import numpy as np
import pytest

from unstructured_mg.matching.window import spline_weights, triangle_weights, window_lengths, windowed_means


@pytest.mark.parametrize("k", [1, 2, 10])
def test_weights_are_six_boxes_convolved(k):
    fine = 600  # samples between frames; the support is 2 (k + 1) frames wide
    box = np.ones(round(2 * (k + 1) * fine / 6))
    spline = box
    for _ in range(5):
        spline = np.convolve(spline, box)
    places = np.linspace(-1, 1, len(spline)) * (k + 1) * len(spline) / (6 * len(box))
    sampled = np.interp(np.arange(-k, k + 1), places, spline)
    np.testing.assert_allclose(spline_weights(k), sampled / sampled.sum(), atol=2e-3)
    assert spline_weights(k).sum() == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(spline_weights(k), spline_weights(k)[::-1], rtol=1e-12)


def test_means_are_weighted_and_missing_near_the_ends():
    values = np.random.default_rng(0).random(12)
    means = windowed_means(values, spline_weights(3))
    assert np.isnan(means[[0, 1, 2, 9, 10, 11]]).all()
    for i in range(3, 9):
        assert means[i] == pytest.approx(spline_weights(3) @ values[i - 3 : i + 4], rel=1e-12)
    assert np.isnan(windowed_means(values[:6], spline_weights(3))).all()


def test_triangle_weights_are_those_of_huang_equation_4():
    for n in (3, 7, 21):
        k = np.arange(-(n - 1) // 2, (n - 1) // 2 + 1)
        expected = np.minimum(k + (n + 1) / 2, -k + (n + 1) / 2)
        np.testing.assert_allclose(triangle_weights(n // 2), expected / expected.sum(), rtol=1e-14)


def test_lengths_lie_evenly_from_the_smallest_to_the_largest():
    assert window_lengths(10, 20) == (10, 12, 15, 18, 20)
    assert window_lengths(3, 5) == (3, 4, 5)
    assert window_lengths(4, 4) == (4,)
