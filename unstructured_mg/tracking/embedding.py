"""A full surface carried by a coarse tet cage."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.geometry.means import weighted_means
from unstructured_mg.geometry.rotations import fit_rotations
from unstructured_mg.geometry.tets import barycentric, deformation_gradients, tet_gradients


@dataclass(frozen=True)
class Cage:
    """A tet cage at rest in the template frame, and how it carries the template's clean surface.

    Attributes
    ----------
    vertices : (c, 3) float64, metres
    tets : (q, 4) int32, positively oriented
    tet_of_vertex : (n,) int32 the cell that carries each surface vertex
    weights : (n, 4) float64 barycentric weights in that cell
    residual : (n, 3) float64 surface minus embedding at rest (zero where every vertex lies in its cell)
    method : "lattice" or "tetwild"
    """

    vertices: np.ndarray
    tets: np.ndarray
    tet_of_vertex: np.ndarray
    weights: np.ndarray
    residual: np.ndarray
    method: str


def make_cage(
    vertices: np.ndarray, tets: np.ndarray, surface: np.ndarray, tet_of_vertex: np.ndarray, method: str
) -> Cage:
    """Embed surface vertices (n, 3) in the tets given for them.

    Weights of points outside are clamped to the tet, so that they never swing; the rest is the residual.
    """
    weights = barycentric(vertices, tets, surface, tet_of_vertex)
    clamped = np.maximum(weights, 0)
    outside = weights.min(axis=1, keepdims=True) < -1e-9
    weights = np.where(outside, clamped / clamped.sum(1, keepdims=True), weights)
    residual = surface - np.einsum("ni,nix->nx", weights, vertices[tets[tet_of_vertex]])
    residual[np.abs(residual).max(1) < 1e-9] = 0.0
    return Cage(vertices, tets, tet_of_vertex.astype(np.int32), weights, residual, method)


def tet_rotations(cage_rest: np.ndarray, tets: np.ndarray, cage_vertices: np.ndarray) -> np.ndarray:
    """The rotation (q, 3, 3) of every tet from rest to ``cage_vertices``."""
    return fit_rotations(deformation_gradients(cage_vertices, tets, tet_gradients(cage_rest, tets)))


def embed(
    cage_vertices: np.ndarray,
    tets: np.ndarray,
    tet_of_vertex: np.ndarray,
    weights: np.ndarray,
    rotations: np.ndarray,
    residual: np.ndarray,
) -> np.ndarray:
    """Surface (n, 3) from cage vertices (c, 3): sum_i w_i x_i + R_tet residual, with rotations (q, 3, 3)."""
    carried = weighted_means(tets, tet_of_vertex, weights, cage_vertices)
    return carried + np.einsum("nab,nb->na", rotations[tet_of_vertex], residual)


def residual_of(
    surface: np.ndarray,
    cage_vertices: np.ndarray,
    tets: np.ndarray,
    tet_of_vertex: np.ndarray,
    weights: np.ndarray,
    rotations: np.ndarray,
) -> np.ndarray:
    """The residual (n, 3) with which ``embed`` gives ``surface`` exactly."""
    carried = weighted_means(tets, tet_of_vertex, weights, cage_vertices)
    return np.einsum("nba,nb->na", rotations[tet_of_vertex], surface - carried)
