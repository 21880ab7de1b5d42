"""Tetrahedral meshes: volumes, hat-function gradients, deformation gradients, embeddings."""

import numpy as np

from unstructured_mg.geometry.elements import element_deformations


def tet_volumes(vertices: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Signed volumes ``(q,) float64``; vertices (c, 3) float64, tets (q, 4) int32."""
    a, b, c, d = (vertices[tets[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0


def tet_gradients(vertices: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Gradients ``(q, 4, 3) float64`` of the four hat functions of each tet. Volumes must not be zero."""
    edges = vertices[tets[:, 1:]] - vertices[tets[:, :1]]
    last_three = np.linalg.inv(edges).transpose(0, 2, 1)
    return np.concatenate([-last_three.sum(1, keepdims=True), last_three], axis=1)


def deformation_gradients(vertices: np.ndarray, tets: np.ndarray, rest_gradients: np.ndarray) -> np.ndarray:
    """L ``(q, 3, 3)``: the linear part of the map that takes each rest tet to the one at ``vertices`` (P A.2)."""
    return element_deformations(vertices, tets, rest_gradients)


def barycentric(vertices: np.ndarray, tets: np.ndarray, points: np.ndarray, tet_of_point: np.ndarray) -> np.ndarray:
    """Weights ``(p, 4)``, summing to 1, of points (p, 3) in the tets (p,) given; negative outside."""
    corner = vertices[tets[tet_of_point]]
    edges = (corner[:, 1:] - corner[:, :1]).transpose(0, 2, 1)
    last_three = np.linalg.solve(edges, (points - corner[:, 0])[:, :, None])[:, :, 0]
    return np.concatenate([1 - last_three.sum(1, keepdims=True), last_three], axis=1)
