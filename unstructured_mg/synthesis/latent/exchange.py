"""More shapes to learn from: limbs exchanged between captured frames.

A hundred frames are few for a network. Which postures of the parts the actor can take is in the capture; that the arm
of one frame goes with the legs of another is not. So parts of the surface take their deformation from other frames,
turned with the part that they hang on, and the surface is stitched as in B eq. 13.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra
from scipy.spatial.transform import Rotation

from unstructured_mg.geometry.laplacian import stiffness_matrix
from unstructured_mg.geometry.rotations import fit_rotations
from unstructured_mg.geometry.solver import SymmetricSolver
from unstructured_mg.geometry.triangles import TriangleElements
from unstructured_mg.synthesis.latent.centre import centre_on
from unstructured_mg.synthesis.two_sided import PinnedSolver

PARTS = 24
# Parts pass into each other over about this share of the bounding box's diagonal.
PASSAGE = 0.02
MOST_EXCHANGES = 3
LEAST_STRENGTH = 0.3


class Exchange:
    """Parts of a surface, each with all that hangs on it, and the frames to exchange them between.

    The parts are the Voronoi regions, along the surface, of points that lie far from each other; the tree of shortest
    ways from the part nearest the centroid says what hangs on what.

    ``shapes`` (f, n, 3) float64, centred; ``faces`` (m, 3) int32.
    """

    def __init__(self, shapes: np.ndarray, faces: np.ndarray):
        self.shapes, self.mean = shapes, shapes.mean(axis=0)
        rest = shapes[((shapes - self.mean) ** 2).sum(axis=(1, 2)).argmin()]
        self._elements = TriangleElements(rest, faces)
        stiffness = stiffness_matrix(rest, faces)
        self._solver = PinnedSolver(stiffness)
        label, self._parent, self._hanging = _part_tree(rest, faces)
        self._fields = self._smooth_fields(rest, faces, stiffness, label)
        corner_label = label[faces[:, 0]]
        count = len(self._parent)
        gather = (self._elements.areas, (corner_label, np.arange(len(faces))))
        self._gather = sp.csr_matrix(gather, shape=(count, len(faces)))
        gradients = [self._elements.deformation(shape) for shape in shapes]
        self._turns = [fit_rotations(each) for each in gradients]
        self._stretches = [t.transpose(0, 2, 1) @ g for t, g in zip(self._turns, gradients, strict=True)]
        self._part_turns = [self._mean_turns(each) for each in self._turns]

    def draw(self, random: np.random.Generator) -> np.ndarray:
        """One new shape ``(n, 3) float64``, centred: a frame with up to three parts taken from others."""
        frame = int(random.integers(len(self.shapes)))
        turn, stretch, part_turn = self._turns[frame], self._stretches[frame], self._part_turns[frame]
        for _ in range(int(random.integers(1, MOST_EXCHANGES + 1))):
            part = int(random.integers(1, len(self._parent)))
            other = int(random.integers(len(self.shapes)))
            parent = self._parent[part]
            share = float(random.uniform(LEAST_STRENGTH, 1.0)) * self._fields[part]
            hung = part_turn[parent] @ self._part_turns[other][parent].T @ self._turns[other]
            step = Rotation.from_matrix(turn.transpose(0, 2, 1) @ hung).as_rotvec()
            turn = turn @ Rotation.from_rotvec(share[:, None] * step).as_matrix()
            stretch = stretch + share[:, None, None] * (self._stretches[other] - stretch)
            part_turn = self._mean_turns(turn)
        made = self._solver.solve(self._elements.divergence(turn @ stretch), self.shapes[frame])
        return centre_on(made, self.mean).shape

    def _mean_turns(self, turns: np.ndarray) -> np.ndarray:
        """Mean rotation ``(p, 3, 3)`` of every part, by area."""
        return fit_rotations((self._gather @ turns.reshape(-1, 9)).reshape(-1, 3, 3))

    def _smooth_fields(
        self, rest: np.ndarray, faces: np.ndarray, stiffness: sp.spmatrix, label: np.ndarray
    ) -> list[np.ndarray]:
        """For every part 1 on it and on what hangs on it, 0 elsewhere, smoothed along the surface; (m,) a part."""
        areas = np.zeros(len(rest))
        np.add.at(areas, faces.ravel(), np.repeat(self._elements.areas / 3, 3))
        reach = PASSAGE * float(np.linalg.norm(np.ptp(rest, axis=0)))
        areas = np.maximum(areas, 1e-6 * areas.mean())  # a vertex without area must not make the system singular
        solver = SymmetricSolver(sp.diags(areas) + reach**2 * stiffness)
        fields = []
        for hanging in self._hanging:
            indicator = np.isin(label, hanging).astype(np.float64)
            smooth = solver.solve(np.repeat((areas * indicator)[:, None], 3, axis=1))[:, 0]
            fields.append(np.clip(smooth, 0.0, 1.0)[faces].mean(axis=1))
        return fields


def _part_tree(rest: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[list[int]]]:
    """Part of every vertex (n,), parent of every part (p,), and for every part itself and all below it.

    Part 0 is the root; pieces that are not connected with it hang on it.
    """
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    lengths = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
    graph = sp.csr_matrix((np.maximum(lengths, 1e-12), edges.T), shape=(len(rest), len(rest)))
    used = np.unique(faces)
    seeds = [int(used[np.linalg.norm(rest[used], axis=1).argmin()])]
    ways = [dijkstra(graph, directed=False, indices=seeds[0])]
    while len(seeds) < min(PARTS, len(used)):
        nearest = np.min(ways, axis=0)[used]
        seeds.append(int(used[nearest.argmax()]))
        ways.append(dijkstra(graph, directed=False, indices=seeds[-1]))
    label = np.argmin(ways, axis=0)
    between = label[edges]
    crossing = between[between[:, 0] != between[:, 1]]
    steps = np.zeros((len(seeds), len(seeds)))
    for a, b in np.unique(np.sort(crossing, axis=1), axis=0):
        steps[a, b] = ways[a][seeds[b]]
    far, parent = dijkstra(sp.csr_matrix(steps), directed=False, indices=0, return_predecessors=True)
    parent = np.where(parent < 0, 0, parent)
    hanging = [[part] for part in range(len(seeds))]
    for part in np.argsort(-np.where(np.isfinite(far), far, -1.0), kind="stable"):
        if part:
            hanging[parent[part]] = hanging[parent[part]] + hanging[part]
    return label, parent, hanging
