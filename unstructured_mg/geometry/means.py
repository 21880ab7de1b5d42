"""What points inside triangles or tets get from the corners."""

import numpy as np

from unstructured_mg import _native


def weighted_means(elements: np.ndarray, element: np.ndarray, weights: np.ndarray, values: np.ndarray) -> np.ndarray:
    """``(p, d) float64``: for every point, sum_c weights[p, c] values[elements[element[p], c]].

    ``elements`` (m, corners) int32, triangles or tets; ``element`` (p,) which of them each point is in; ``weights``
    (p, corners); ``values`` (n, d), one row a vertex. ValueError where shapes do not fit, IndexError out of range.
    """
    elements, element = np.ascontiguousarray(elements, np.int32), np.ascontiguousarray(element, np.int32)
    weights, values = np.ascontiguousarray(weights, np.float64), np.ascontiguousarray(values, np.float64)
    if elements.ndim != 2 or values.ndim != 2:
        raise ValueError(f"elements, values: expected two axes each, got {elements.shape} and {values.shape}")
    if weights.shape != (len(element), elements.shape[1]):
        raise ValueError(f"weights: expected {(len(element), elements.shape[1])}, got {weights.shape}")
    means = np.empty((len(element), values.shape[1]))
    _native.weighted_means(elements.shape[1], values.shape[1], element, elements, weights, values, means)
    return means
