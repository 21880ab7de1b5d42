"""Detail transfer (P section 5.5, A.3): replace the template's normal offsets from a smooth base by the target's."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from unstructured_mg.geometry.closest import ClosestPoints
from unstructured_mg.geometry.laplacian import stiffness_matrix
from unstructured_mg.geometry.normals import vertex_normals
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.surface import unit, vertex_areas


@dataclass(frozen=True)
class DetailLayers:
    """A surface as a smooth base and normal offsets to it, level by level.

    ``base`` (n, 3) = surface + sum over levels of offsets * normals; ``normals`` (levels, n, 3) smoothed; ``offsets``
    (levels, n).
    """

    base: np.ndarray
    normals: np.ndarray
    offsets: np.ndarray


def smooth_normals(
    normals: np.ndarray, masses: np.ndarray, stiffness: sp.csr_matrix, weight: float, tolerance: float = 1e-4
) -> np.ndarray:
    """Unit normals (n, 3) after the tangential offsets t that minimise |t|^2 + weight |grad (n + t)|^2 (P eq. 1, A.3).

    ``masses`` (n,) lumped areas, ``stiffness`` (n, n) positive semi-definite. With Delta = -M^-1 S the system is
    P (M + weight S) P t = -weight P S n, P projecting onto the tangent planes (no tangent basis is needed).
    """

    def project(vectors: np.ndarray) -> np.ndarray:
        return vectors - np.einsum("nx,nx->n", normals, vectors)[:, None] * normals

    diagonal = (masses + weight * stiffness.diagonal())[:, None]
    offsets = _conjugate_gradients(
        lambda t: project(masses[:, None] * t + weight * (stiffness @ t)),
        diagonal,
        project(-weight * (stiffness @ normals)),
        tolerance,
    )
    return unit(normals + offsets)


def normal_offsets(
    vertices: np.ndarray,
    normals: np.ndarray,
    masses: np.ndarray,
    stiffness: sp.csr_matrix,
    weight: float,
    tolerance: float = 1e-4,
) -> np.ndarray:
    """Offsets h (n,) of zero mean that minimise h^2 + weight |grad (v + h n)|^2 (P eq. 2, A.3).

    The system is N^T (M + weight S) N h = -weight N^T S v with N = diag(normals).
    """

    def apply(h: np.ndarray) -> np.ndarray:
        return masses * h + weight * np.einsum("nx,nx->n", normals, stiffness @ (normals * h[:, None]))

    right = -weight * np.einsum("nx,nx->n", normals, stiffness @ vertices)
    offsets = _conjugate_gradients(apply, masses + weight * stiffness.diagonal(), right, tolerance)
    return offsets - (masses * offsets).sum() / masses.sum()


def detail_layers(vertices: np.ndarray, faces: np.ndarray, options: TrackingOptions) -> DetailLayers:
    """Peel ``options.detail_levels`` layers off a surface, normals smoothed four times more at every level.

    The paper's weights are areas for a surface of unit area; here they are scaled by the surface's.
    """
    base, normals, offsets = vertices, [], []
    for level in range(options.detail_levels):
        areas = vertex_areas(base, faces)
        area = areas.sum()
        masses = np.maximum(areas, 1e-6 * areas.mean())
        stiffness = stiffness_matrix(base, faces).tocsr()
        smooth = smooth_normals(
            vertex_normals(base, faces), masses, stiffness, options.detail_normals * 4**level * area
        )
        height = normal_offsets(base, smooth, masses, stiffness, options.detail_offsets * area)
        base = base + height[:, None] * smooth
        normals.append(smooth)
        offsets.append(height)
    return DetailLayers(base, np.stack(normals), np.stack(offsets))


def transfer_detail(
    vertices: np.ndarray,
    faces: np.ndarray,
    target_vertices: np.ndarray,
    target_faces: np.ndarray,
    options: TrackingOptions,
) -> np.ndarray:
    """The registered template (n, 3) with the target's detail: its base minus the target's offsets, pulled back by
    closest points between the bases (P eq. 3), along its own smooth normals."""
    own = detail_layers(vertices, faces, options)
    theirs = detail_layers(target_vertices, target_faces, options)
    tree = ClosestPoints(theirs.base, target_faces)
    _, face, nearest = tree.query(own.base)
    weights = tree.barycentric(face, nearest)
    pulled = np.einsum("pi,lpi->lp", weights, theirs.offsets[:, target_faces[face]])
    return own.base - np.einsum("lp,lpx->px", pulled, own.normals)


def _conjugate_gradients(
    apply: Callable[[np.ndarray], np.ndarray], diagonal: np.ndarray, right: np.ndarray, tolerance: float
) -> np.ndarray:
    """Solve a symmetric positive definite system to ``tolerance`` of the right side's norm, Jacobi-preconditioned."""
    answer = np.zeros_like(right)
    rest = right.copy()
    goal = tolerance * np.sqrt((right * right / diagonal).sum())
    scaled = rest / diagonal
    direction = scaled.copy()
    energy = float((rest * scaled).sum())
    for _ in range(400):
        if np.sqrt(energy) <= goal:
            break
        image = apply(direction)
        length = energy / float((direction * image).sum())
        answer += length * direction
        rest -= length * image
        scaled = rest / diagonal
        before, energy = energy, float((rest * scaled).sum())
        direction = scaled + energy / before * direction
    return answer
