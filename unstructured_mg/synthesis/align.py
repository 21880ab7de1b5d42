"""Bringing the target window to the source on the floor plane (P section 6.1)."""

import numpy as np

from unstructured_mg.geometry.laplacian import face_areas
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.geometry.rotations import fit_planar
from unstructured_mg.tracking.pair import TrackedPair


def vertex_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """A third of the area of each vertex's one-ring, ``(n,) float64``, square metres."""
    return np.bincount(faces.ravel(), np.repeat(face_areas(vertices, faces) / 3, 3), minlength=len(vertices))


def align_windows(pair: TrackedPair) -> PlanarRigid:
    """The floor-plane motion that brings the target's place to the source's.

    Minimises sum_i w_i m_i |p_i^s - (R p_i^t + o)|^2 over yaw and 2-D shift, p^s and p^t the tracked surface at the
    windows' centres, with w_i = exp(-(z_i^s + z_i^t)^2 / (2 sigma^2)) and sigma^2 the mass-weighted mean of
    (z_i^s + z_i^t)^2: what is near the ground counts most, so that feet do not glide.

    The masses m_i are surface areas (mean of both frames), where the paper takes volumes of tetrahedra: our cage is
    coarse and its corners lie off the body, while the soles that must not glide are surface. Swapping source and
    target gives the inverse motion.
    """
    half = 2 * pair.k + 1
    source, target = pair.vertices[pair.k], pair.vertices[half + pair.k]
    masses = vertex_areas(source, pair.faces) + vertex_areas(target, pair.faces)
    heights = source[:, 2] + target[:, 2]
    variance = masses @ heights**2 / masses.sum()
    if variance > 0:
        masses = masses * np.exp(-(heights**2) / (2 * variance))
    return fit_planar(target, source, masses)
