import numpy as np
import pytest

from unstructured_mg.geometry.means import weighted_means


@pytest.mark.parametrize(("corners", "columns"), [(3, 6), (4, 3), (3, 1)])
def test_means_are_the_sums_over_the_corners(corners, columns):
    rng = np.random.default_rng(0)
    elements = rng.integers(0, 50, (80, corners)).astype(np.int32)
    element, weights, values = rng.integers(0, 80, 200), rng.random((200, corners)), rng.normal(size=(50, columns))
    expected = np.einsum("pc,pcd->pd", weights, values[elements[element]])
    np.testing.assert_allclose(weighted_means(elements, element, weights, values), expected, atol=1e-13)


def test_what_does_not_fit_is_refused():
    elements, values = np.array([[0, 1, 2]], np.int32), np.zeros((3, 2))
    with pytest.raises(ValueError, match="weights"):
        weighted_means(elements, np.zeros(2, np.int32), np.ones((2, 4)), values)
    with pytest.raises(ValueError, match="values"):
        weighted_means(elements, np.zeros(2, np.int32), np.ones((2, 3)), np.zeros(3))
    for bad in (-1, 1):
        with pytest.raises(IndexError):
            weighted_means(elements, np.array([bad]), np.ones((1, 3)), values)
    with pytest.raises(IndexError):
        weighted_means(np.array([[0, 1, 3]]), np.array([0]), np.ones((1, 3)), values)
