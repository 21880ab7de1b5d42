"""The cotangent Laplacian and lumped masses of triangle meshes (P appendix A, "Geometry")."""

import numpy as np
import scipy.sparse as sp


def face_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Areas ``(m,) float64`` of triangles; vertices (n, 3) float64, faces (m, 3) int32."""
    a, b, c = vertices[faces[:, 0]], vertices[faces[:, 1]], vertices[faces[:, 2]]
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def mass_matrix(vertices: np.ndarray, faces: np.ndarray) -> sp.csc_matrix:
    """Lumped mass M ``(n, n)``: a third of the area of each vertex's one-ring on the diagonal."""
    areas = face_areas(vertices, faces)
    masses = np.bincount(faces.ravel(), np.repeat(areas / 3, 3), minlength=len(vertices))
    return sp.diags(masses).tocsc()


def stiffness_matrix(vertices: np.ndarray, faces: np.ndarray) -> sp.csc_matrix:
    """Stiffness S ``(n, n)``, positive semi-definite: ``f^T S f`` is the Dirichlet energy of the hat-basis function f.

    Zero-area triangles have no gradient and are left out.
    """
    n = len(vertices)
    rows, columns, values = [], [], []
    for i in range(3):
        apex, j, k = faces[:, i], faces[:, (i + 1) % 3], faces[:, (i + 2) % 3]
        u, v = vertices[j] - vertices[apex], vertices[k] - vertices[apex]
        double_area = np.linalg.norm(np.cross(u, v), axis=1)
        longest = np.maximum(np.einsum("ij,ij->i", u, u), np.einsum("ij,ij->i", v, v))
        usable = double_area > 1e-10 * np.maximum(longest, 1e-300)
        half_cotangent = np.where(usable, 0.5 * np.einsum("ij,ij->i", u, v) / np.where(usable, double_area, 1.0), 0.0)
        rows += [j, k, j, k]
        columns += [k, j, j, k]
        values += [-half_cotangent, -half_cotangent, half_cotangent, half_cotangent]
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sp.coo_matrix(entries, shape=(n, n)).tocsc()
