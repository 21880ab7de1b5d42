"""Feet that stand keep standing: what blending two stances makes slide is locked, and made up for while a foot swings.

Where a foot stands in both windows, but not in the same place, the blend carries it over the floor from one place to
the other. Here it stays, and the way is caught up on in the steps in which it does not stand.
"""

import numpy as np
import scipy.sparse as sp
from scipy.optimize import lsq_linear

from unstructured_mg.geometry.arap import arap_stiffness
from unstructured_mg.geometry.components import face_components, weld
from unstructured_mg.geometry.solver import SymmetricSolver
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.synthesis.align import vertex_areas
from unstructured_mg.synthesis.contact import planted
from unstructured_mg.synthesis.posture import Posture, Template

# Metres: surface that comes this low somewhere in the windows is a foot, where some of it is planted.
FOOT_HEIGHT = 0.1
# Metres over which a foot's correction fades into the body's.
LEG_LENGTH = 0.25
# A correction changes a foot's velocity by at most this share of what the captured foot's velocity changes by.
SHARE_OF_TURN = 0.5


def plant_feet(
    template: Template, steps: list[Posture], first: list[Posture], second: list[Posture], weights: np.ndarray
) -> list[Posture]:
    """The ``2k+1`` steps of a transition with its planted feet locked; both ends stay as they are.

    For each foot the correction c (one floor vector a step) minimises
    ``sum over planted steps |c_i+1 - c_i + slide_i|^2``, slide what the blend adds to the blend of the windows' own
    motion, with c zero at both ends and beyond, and with every change of its velocity, c_i+1 - 2 c_i + c_i-1, bounded
    by what the captured foot does. The body moves by the mean of its feet's corrections, so that legs only take up what
    the feet differ by; between foot and body the correction fades with a harmonic weight on the cage.

    steps, first and second are the transition and both windows in one place, ``weights`` (2k+1,) the blend's.
    """
    moving, left, right = (np.stack([posture.surface for posture in postures]) for postures in (steps, first, second))
    standing = [planted(left, right, i) for i in range(len(steps) - 1)]
    feet = find_feet(
        template, np.minimum(left[:, :, 2].min(axis=0), right[:, :, 2].min(axis=0)), np.any(standing, axis=0)
    )
    if not feet:
        return steps
    areas = vertex_areas(template.surface, template.faces)
    corrections = []
    for foot in feet:
        slides, stands = np.zeros((len(standing), 2)), np.zeros(len(standing), bool)
        for i, here in enumerate(standing):
            sole = np.flatnonzero(here & foot)
            if areas[sole].sum() <= 0:
                continue
            share = (weights[i] + weights[i + 1]) / 2
            own = (1 - share) * (left[i + 1] - left[i])[sole] + share * (right[i + 1] - right[i])[sole]
            extra = (moving[i + 1] - moving[i])[sole] - own
            slides[i], stands[i] = areas[sole] @ extra[:, :2] / areas[sole].sum(), True
        paths = [areas[foot] @ window[:, foot, :2] / areas[foot].sum() for window in (left, right)]
        turn = max(float(np.linalg.norm(np.diff(path, n=2, axis=0), axis=1).max()) for path in paths)
        corrections.append(lock(slides, stands, SHARE_OF_TURN * turn))
    on_cage = _foot_weights(template, feet)
    rows = np.repeat(np.arange(len(template.surface)), 4)
    columns = template.tets[template.tet_of_vertex].ravel()
    carry = sp.csr_matrix((template.weights.ravel(), (rows, columns)), (len(template.surface), len(template.cage)))
    on_surface = carry @ on_cage
    body = np.mean(corrections, axis=0)
    apart = np.stack([c - body for c in corrections], axis=1)
    return [
        steps[0],
        *(_moved(steps[i], body[i], apart[i], on_surface, on_cage) for i in range(1, len(steps) - 1)),
        steps[-1],
    ]


def find_feet(template: Template, lowest: np.ndarray, planted_ever: np.ndarray) -> list[np.ndarray]:
    """Masks (n,) bool of what stands: connected surface that comes near the floor and is planted somewhere.

    ``lowest`` (n,) metres, the least height of each vertex in both windows; ``planted_ever`` (n,) bool.
    """
    _, faces, welded = weld(template.surface, template.faces)
    low = np.zeros(len(template.surface), bool)
    low[welded[lowest < FOOT_HEIGHT]] = True
    near = low[faces].all(axis=1)
    if not near.any():
        return []
    labels = np.full(len(template.surface), -1, np.int64)
    labels[faces[near].ravel()] = np.repeat(face_components(len(template.surface), faces[near]), 3)
    of_vertex = labels[welded]
    return [of_vertex == label for label in np.unique(of_vertex[planted_ever]) if label >= 0]


def lock(slides: np.ndarray, stands: np.ndarray, turn: float) -> np.ndarray:
    """A foot's correction ``(s + 1, 2)`` for its slides (s, 2) where it stands (s,) bool; see ``plant_feet``.

    ``turn`` bounds the change of its velocity along each axis, metres a step.
    """
    count = len(slides)
    # Unknown are the changes of velocity a at steps 0 .. s, with rest before and after: c_j = sum_i<j (j - i) a_i.
    places = np.maximum(np.arange(count + 1)[:, None] - np.arange(count + 1)[None], 0).astype(np.float64)
    ends = 1e3 * np.stack([places[-1], np.ones(count + 1)])
    # Of many corrections that lock alike the one with the least turning.
    matrix = np.concatenate([np.diff(places, axis=0)[stands], ends, 1e-3 * np.eye(count + 1)])
    right = np.concatenate([-slides[stands], np.zeros((count + 3, 2))])
    correction = np.zeros((count + 1, 2))
    if turn > 0:
        for axis in (0, 1):
            turns = lsq_linear(matrix, right[:, axis], (-turn, turn), method="bvls").x
            correction[:, axis] = places @ turns
    correction[[0, -1]] = 0
    return correction


def _foot_weights(template: Template, feet: list[np.ndarray]) -> np.ndarray:
    """How far (c, feet) each cage vertex goes with each foot: 1 there, fading over LEG_LENGTH, 0 at the other feet."""
    volumes = np.abs(tet_volumes(template.cage, template.tets))
    masses = np.bincount(template.tets.ravel(), np.repeat(volumes / 4, 4), minlength=len(template.cage))
    held = np.zeros((len(template.cage), len(feet)))
    for i, foot in enumerate(feet):
        held[template.tets[template.tet_of_vertex[foot]].ravel(), i] = 1
    share = held.sum(axis=1, keepdims=True)
    held = np.divide(held, share, out=held, where=share > 0)
    strength = sp.diags(np.where(share[:, 0] > 0, 1e3 * masses / LEG_LENGTH**2, 0.0))
    matrix = arap_stiffness(template.cage, template.tets) + sp.diags(masses / LEG_LENGTH**2) + strength
    return SymmetricSolver(matrix).solve(strength @ held)


def _moved(
    posture: Posture, body: np.ndarray, apart: np.ndarray, on_surface: np.ndarray, on_cage: np.ndarray
) -> Posture:
    surface = posture.surface.copy()
    surface[:, :2] += body + on_surface @ apart
    if posture.cage is None:
        return Posture(surface, None)
    cage = posture.cage.copy()
    cage[:, :2] += body + on_cage @ apart
    return Posture(surface, cage)
