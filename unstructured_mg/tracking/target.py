"""A surface to register to: prepared once a frame, queried in every iteration."""

from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from unstructured_mg.geometry.means import weighted_means
from unstructured_mg.geometry.nearest import NearestPoints
from unstructured_mg.geometry.normals import vertex_normals
from unstructured_mg.tracking.surface import CleanSurface, unit, vertex_areas


class Target:
    """Closest points and samples of a clean surface.

    ``spacing`` and ``sparse_spacing`` (metres) are the distances of the samples that stand for the surface in coarse
    and in the coarsest stages.
    """

    def __init__(self, surface: CleanSurface, spacing: float, sparse_spacing: float):
        self.vertices = surface.vertices
        self.faces = surface.faces[surface.geometric]
        self.normals = vertex_normals(self.vertices, self.faces)
        self.areas = vertex_areas(self.vertices, self.faces)
        self._placed_normals = np.concatenate([self.vertices, self.normals], axis=1)
        self._nearest = NearestPoints(self.vertices, self.faces)
        self._slots: dict[int, np.ndarray] = {}
        self.samples = thin(self.vertices, self.areas, spacing)
        self.sparse = thin(self.vertices, self.areas, sparse_spacing)
        self._turn_scale = 3 * spacing
        self._tree = cKDTree(self._lift(self.samples))

    @cached_property
    def sparse_shares(self) -> np.ndarray:
        """Shares of area (samples,) that the sparse samples stand for."""
        return near_shares(self.vertices, self.areas, self.sparse)

    def _lift(self, index: np.ndarray) -> np.ndarray:
        return np.concatenate([self.vertices[index], self._turn_scale * self.normals[index]], axis=1)

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Nearest surface points (p, 3) and smooth normals (p, 3) there."""
        _, face, weights = self._find(points)
        found = weighted_means(self.faces, face, weights, self._placed_normals)
        return np.ascontiguousarray(found[:, :3]), unit(found[:, 3:])

    def alike(self, points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of the samples, those nearest in place and direction together: points and normals (p, 3).

        A right angle between normals counts like a distance of some sample spacings, so that a far limb's front finds
        a front and not the nearer back.
        """
        _, rank = self._tree.query(np.concatenate([points, self._turn_scale * normals], axis=1))
        index = self.samples[rank]
        return self.vertices[index], self.normals[index]

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Distances (p,) of points to the surface."""
        return np.sqrt(self._find(points)[0])

    def _find(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Squared distances (p,), faces (p,) and weights (p, 3) of the nearest points.

        As many points as once before are the same surface's, moved a little: what they found then is where to start.
        """
        squared, face, weights, slots = self._nearest.query(points, self._slots.get(len(points)))
        self._slots[len(points)] = slots
        return squared, face, weights


def thin(vertices: np.ndarray, areas: np.ndarray, spacing: float) -> np.ndarray:
    """Indices of one vertex in each occupied cell of a grid: the first in index order, of those with area."""
    usable = np.flatnonzero(areas > 0)
    cell = np.floor((vertices[usable] - vertices[usable].min(0)) / spacing).astype(np.int64)
    key = (cell[:, 0] << 42) + (cell[:, 1] << 21) + cell[:, 2]
    return usable[np.sort(np.unique(key, return_index=True)[1])]


def near_shares(vertices: np.ndarray, areas: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Shares of area (samples,), sum 1: every vertex counts for the nearest sample."""
    _, nearest = cKDTree(vertices[samples]).query(vertices)
    shares = np.bincount(nearest, areas, minlength=len(samples))
    return shares / shares.sum()
