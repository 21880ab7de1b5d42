"""Bringing the target window to the source on the floor plane (P section 6.1)."""

import numpy as np

from unstructured_mg.geometry.laplacian import face_areas
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.geometry.rotations import fit_planar
from unstructured_mg.synthesis.contact import planted
from unstructured_mg.synthesis.weights import cubic_weights
from unstructured_mg.tracking.pair import TrackedPair

# How much soles that stand weigh against whole bodies. On two pairs of a walking actor, whose bodies agree 10 to 15 cm
# beside where their feet do, planted soles slid by 8 and 14 cm at 0, by 4 and 8 at 3 and by 3 and 5 at 10.
CONTACT_WEIGHT = 10.0


def vertex_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """A third of the area of each vertex's one-ring, ``(n,) float64``, square metres."""
    return np.bincount(faces.ravel(), np.repeat(face_areas(vertices, faces) / 3, 3), minlength=len(vertices))


def align_windows(pair: TrackedPair) -> PlanarRigid:
    """The floor-plane motion that brings the target's place to the source's.

    Minimises sum_i w_i m_i |p_i^s - (R p_i^t + o)|^2 over yaw and 2-D shift, p^s and p^t the tracked surface at the
    windows' centres, with w_i = exp(-(z_i^s + z_i^t)^2 / (2 sigma^2)) and sigma^2 the mass-weighted mean of
    (z_i^s + z_i^t)^2: what is near the ground counts most, so that feet do not glide.

    The masses m_i are surface areas (sum of both frames), where the paper takes volumes of tetrahedra: our cage is
    coarse and its corners lie off the body, while the soles that must not glide are surface.

    What stands in both windows (``contact.planted``) joins the sum at every step, with its own places there, weighted
    by how fast the blend goes on at that step: the way that it would slide. All that stands through the whole windows
    would weigh CONTACT_WEIGHT times as much as the bodies. Swapping source and target gives the inverse motion.
    """
    source, target = pair.vertices[pair.steps[:, pair.k]]
    areas = masses = vertex_areas(source, pair.faces) + vertex_areas(target, pair.faces)
    heights = source[:, 2] + target[:, 2]
    variance = masses @ heights**2 / masses.sum()
    if variance > 0:
        masses = masses * np.exp(-(heights**2) / (2 * variance))
    first, second = (pair.vertices[steps] for steps in pair.steps)
    pace = np.diff(cubic_weights(pair.k))
    standing = [planted(first, second, i) for i in range(2 * pair.k)]
    most = max((float(areas[sole].sum()) for sole in standing), default=0.0)
    if most > 0:
        scale = CONTACT_WEIGHT * masses.sum() / most
        source = np.concatenate([source, *(first[i, sole] for i, sole in enumerate(standing))])
        target = np.concatenate([target, *(second[i, sole] for i, sole in enumerate(standing))])
        masses = np.concatenate([masses, *(scale * pace[i] * areas[sole] for i, sole in enumerate(standing))])
    return fit_planar(target, source, masses)
