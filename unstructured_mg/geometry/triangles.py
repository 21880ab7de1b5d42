"""Deformation gradients of triangles, their unit normals taken along (B eq. 9)."""

import numpy as np

from unstructured_mg.geometry.elements import element_deformations, element_forces


class TriangleElements:
    """The triangles of a template as elements: gradients of their hat functions, areas, normals.

    Triangles without area have no gradient: their area here is 0 and they pull at nothing.

    Attributes
    ----------
    gradients : (m, 3, 3) float64, the gradient of each corner's hat function, 1/m
    areas : (m,) float64, square metres
    normals : (m, 3) float64, unit
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        self.faces = faces
        self.vertex_count = len(vertices)
        a, b, c = (vertices[faces[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        double_area = np.linalg.norm(normal, axis=1)
        longest = np.max([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)], axis=0)
        usable = double_area > 1e-10 * np.maximum(longest, 1e-300)
        inverse = np.where(usable, 1 / np.where(usable, double_area, 1.0), 0.0)[:, None]
        self.normals = normal * inverse
        self.gradients = np.stack([np.cross(self.normals, e) * inverse for e in (c - b, a - c, b - a)], axis=1)
        self.areas = np.where(usable, double_area / 2, 0.0)

    def tangential(self, vertices: np.ndarray) -> np.ndarray:
        """F ``(m, 3, 3)``: the linear map from a template triangle to the one at ``vertices``; the normal goes to 0."""
        return element_deformations(vertices, self.faces, self.gradients)

    def deformation(self, vertices: np.ndarray) -> np.ndarray:
        """F ``(m, 3, 3)``: the linear map from a template triangle and its unit normal to those at ``vertices``."""
        corners = vertices[self.faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal = normal / np.where(length > 0, length, 1.0)
        return self.tangential(vertices) + normal[:, :, None] * self.normals[:, None, :]

    def divergence(self, targets: np.ndarray) -> np.ndarray:
        """G^T D T ``(n, 3)``: the right-hand side of B eq. 13 for wanted deformations ``targets`` (m, 3, 3)."""
        return element_forces(self.vertex_count, self.faces, self.gradients, self.areas, targets)
