import numpy as np
import pytest

from unstructured_mg.matching.window import window_weights, windowed_means


@pytest.mark.parametrize("k", [1, 2, 10])
def test_weights_are_six_boxes_convolved(k):
    fine = 600  # samples between frames; the support is 2 (k + 1) frames wide
    box = np.ones(round(2 * (k + 1) * fine / 6))
    spline = box
    for _ in range(5):
        spline = np.convolve(spline, box)
    places = np.linspace(-1, 1, len(spline)) * (k + 1) * len(spline) / (6 * len(box))
    sampled = np.interp(np.arange(-k, k + 1), places, spline)
    np.testing.assert_allclose(window_weights(k), sampled / sampled.sum(), atol=2e-3)
    assert window_weights(k).sum() == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(window_weights(k), window_weights(k)[::-1], rtol=1e-12)


def test_means_are_weighted_and_missing_near_the_ends():
    values = np.random.default_rng(0).random(12)
    means = windowed_means(values, 3)
    assert np.isnan(means[[0, 1, 2, 9, 10, 11]]).all()
    for i in range(3, 9):
        assert means[i] == pytest.approx(window_weights(3) @ values[i - 3 : i + 4], rel=1e-12)
    assert np.isnan(windowed_means(values[:6], 3)).all()
