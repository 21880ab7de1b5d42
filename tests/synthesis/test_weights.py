import numpy as np

from unstructured_mg.synthesis.weights import cubic_weights, linear_weights


def test_weights_as_the_paper_writes_them():
    k = 10
    i = np.arange(-k, k + 1)
    np.testing.assert_allclose(linear_weights(k), (i + k) / (2 * k))
    np.testing.assert_allclose(cubic_weights(k), 3 * ((i + k) / (2 * k)) ** 2 - 2 * ((i + k) / (2 * k)) ** 3)


def test_they_meet_the_ends_and_mirror():
    for weights in (linear_weights(7), cubic_weights(7)):
        assert weights[0] == 0 and weights[-1] == 1
        np.testing.assert_allclose(weights + weights[::-1], 1, atol=1e-15)


def test_cubic_starts_at_rest():
    k = 1000
    assert cubic_weights(k)[1] < 2e-3 * linear_weights(k)[1]
