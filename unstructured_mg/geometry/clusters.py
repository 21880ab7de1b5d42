"""Clusters of neighbouring vertices: the coarse level of solvers."""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components


def cluster_vertices(vertices: np.ndarray, faces: np.ndarray, width: float) -> np.ndarray:
    """Cluster label ``(n,) int32`` of every vertex: the connected pieces of the surface inside cells of a cubic grid.

    vertices (n, 3) float64, faces (m, 3) int32; ``width`` of the cells in the vertices' unit.
    """
    cell = np.floor((vertices - vertices.min(axis=0)) / width).astype(np.int64)
    rows, columns = (int(count) + 1 for count in cell[:, 1:].max(axis=0))
    key = (cell[:, 0] * rows + cell[:, 1]) * columns + cell[:, 2]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = edges[key[edges[:, 0]] == key[edges[:, 1]]]
    n = len(vertices)
    graph = sp.coo_matrix((np.ones(len(edges), np.int8), (edges[:, 0], edges[:, 1])), (n, n))
    return connected_components(graph, directed=False)[1]
