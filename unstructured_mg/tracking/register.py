"""Registering a caged surface to a target surface without correspondence (in place of P section 5.4's Li et al. 2009).

The unknowns are the cage's vertices x. With the surface points p_i(x) = sum_j w_ij x_j they carry, minimise

    sum_i a_i rho(|q_i - p_i|) (n_i . (q_i - p_i))^2  +  sum_j b_j rho(|y_j - p_j|) (n_j . (y_j - p_j))^2
        + rigidity L^2 / V  sum_tets |tet| min_R |F - R|^2 ,

where q_i is the target's point nearest to p_i, p_j the surface point nearest to a target sample y_j, n the mean of the
two normals (symmetric point-to-plane; Rusinkiewicz 2019), rho Welsch's weight exp(-(d / width)^2), times the cosine of
the two normals; a and b are shares of area that each sum to 1. Rigidity and width are annealed. Point-to-plane data
leave the surface free to slide; that it does not is the work of the volume's rigidity, which is therefore lowered
slowly and the target never snapped to.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from unstructured_mg import _native
from unstructured_mg.geometry.means import weighted_means
from unstructured_mg.geometry.normals import vertex_normals
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.tracking.embedding import Cage, embed
from unstructured_mg.tracking.surface import CleanSurface, vertex_areas
from unstructured_mg.tracking.system import CageSystem
from unstructured_mg.tracking.target import Target, near_shares, thin
from unstructured_mg.tracking.transport import Transport

# Samples for transport, whose cost goes with their number squared, are this many times farther apart.
SPARSER = 2.5
# A right angle between normals counts like this distance in a transport's cost, in metres of a body.
_TURN = 0.15

_ROUNDS = 12

# A cage of some thousand unknowns does not gain from more data than this many surface vertices.
_DENSE = 12_000

# Where 99 % of the surface has its like within this distance, in metres of a body, nothing need be searched for.
_NEAR = 0.15
# Where it has within this, twice the samples' spacing, the closest point is the right one and coarse stages change
# nothing (measured to the fourth digit on every row of the benchmark), but take two fifths of the time.
_CLOSE = 0.05

# The lengths below are for a body of this surface area, in square metres; others are scaled by the root of area.
_BODY_AREA = 2.0


@dataclass(frozen=True)
class Stage:
    """One round of the annealing.

    ``rigidity`` as above; ``width`` of Welsch's weight, or blur of the transport, in metres of a body; at most
    ``iterations`` solves. ``points`` says what is matched with what: "plan" sparse samples by transport, "alike"
    samples with samples near in place and direction, "near" samples with their nearest surface points, "all" the same
    for every vertex. ``from_start``: the share of stiffness that is around the start's shape; the rest is the
    template's.
    """

    rigidity: float
    width: float
    iterations: int
    points: str
    from_start: float = 0.0


def near_stages(rigidity: float) -> list[Stage]:
    """From a neighbouring frame: small moves, stiff at first around the start's shape alone.

    At the end half of the stiffness is the template's: all of it would pull long windows back to its pose (measured
    over 20 frames of a lifting leg: 0.31 % of the diagonal against 0.30 %), none of it would let errors add up (0.083 %
    against 0.060 % after 10 frames).
    """
    return [
        Stage(0.3, 0.2, 1, "alike", 1.0),
        Stage(0.03, 0.1, 2, "alike", 1.0),
        Stage(1e-3, 0.03, 1, "near", 1.0),
        Stage(max(1e-4, rigidity), 0.03, 1, "all", 0.5),
        Stage(rigidity, 0.03, 2, "all", 0.5),
    ]


def close_stages(rigidity: float) -> list[Stage]:
    """From a neighbouring frame where little moved: the nearest points are right from the start."""
    return [stage for stage in near_stages(rigidity) if stage.points != "alike"]


def far_stages(rigidity: float) -> list[Stage]:
    """From another window, or with nothing known: limbs find their place by transport first."""
    return [
        Stage(0.3, 0.3, 1, "plan", 1.0),
        Stage(0.3, 0.2, 1, "plan", 1.0),
        Stage(0.1, 0.2, 1, "plan", 1.0),
        Stage(0.1, 0.14, 2, "plan", 1.0),
        Stage(0.03, 0.1, 2, "plan", 1.0),
        Stage(0.01, 0.1, 3, "alike", 1.0),
        Stage(0.01, 0.05, 2, "near", 1.0),
        Stage(1e-3, 0.03, 3, "near", 1.0),
        Stage(3e-4, 0.03, 2, "near", 0.5),
        Stage(max(1e-4, rigidity), 0.03, 2, "all", 0.5),
        Stage(rigidity, 0.03, 2, "all", 0.5),
    ]


class Registrar:
    """Registers one caged surface to any number of targets. ``surface`` is the template's clean surface."""

    def __init__(self, surface: CleanSurface, cage: Cage):
        self.cage = cage
        self.faces = surface.faces[surface.geometric]
        self.areas = vertex_areas(surface.vertices, self.faces)
        self.scale = float(np.sqrt(self.areas.sum() / _BODY_AREA))
        self.spacing = 0.025 * self.scale
        self.samples = thin(surface.vertices, self.areas, self.spacing)
        self.sparse = thin(surface.vertices, self.areas, self.spacing * SPARSER)
        self._dense = _dense_samples(surface.vertices, self.areas)
        self._dense_shares = near_shares(surface.vertices, self.areas, self._dense)
        self.system = CageSystem(cage.vertices, cage.tets)

    def target(self, surface: CleanSurface) -> Target:
        """Prepare a frame as a target for this surface."""
        return Target(surface, self.spacing, self.spacing * SPARSER)

    def gap(self, target: Target, start: np.ndarray) -> float:
        """How far 99 % of the surface at ``start`` (c, 3) have their like on the target, in metres of a body."""
        surface = self.surface_at(start)
        points = surface[self.samples]
        goals, _ = target.alike(points, vertex_normals(surface, self.faces)[self.samples])
        return float(np.percentile(np.linalg.norm(goals - points, axis=1), 99)) / self.scale

    def surface_at(self, cage_vertices: np.ndarray) -> np.ndarray:
        """The carried surface (n, 3) at given cage vertices (c, 3)."""
        cage = self.cage
        if not cage.residual.any():
            return weighted_means(cage.tets, cage.tet_of_vertex, cage.weights, cage_vertices)
        _, rotations = self.system.rotations(cage_vertices)
        return embed(cage_vertices, cage.tets, cage.tet_of_vertex, cage.weights, rotations, cage.residual)

    def stages(self, target: Target, start: np.ndarray, rigidity: float) -> list[Stage]:
        """The annealing that suits the distance between the surface at ``start`` (c, 3) and the target."""
        gap = self.gap(target, start)
        if gap < _CLOSE:
            return close_stages(rigidity)
        return near_stages(rigidity) if gap < _NEAR else far_stages(rigidity)

    def register(self, target: Target, start: np.ndarray, stages: Sequence[Stage]) -> np.ndarray:
        """Cage vertices (c, 3) that bring the surface from ``start`` (c, 3) onto the target; it inverts no tet."""
        vertices = start
        following = CageSystem.like(self.system, start) if any(stage.from_start for stage in stages) else self.system
        floor = 0.05 * self.system.volumes
        # A start may be worse than the floor, never made worse.
        floor = np.minimum(floor, 0.5 * np.maximum(tet_volumes(start, self.cage.tets), 0))
        firmness = np.ones(len(self.cage.tets))
        plan = None
        if any(stage.points == "plan" for stage in stages):
            shares = near_shares(self.surface_at(start), self.areas, self.sparse)
            sparse = target.sparse
            plan = Transport(
                shares, target.vertices[sparse], target.normals[sparse], target.sparse_shares, _TURN * self.scale
            )
        for stage in stages:
            for _ in range(stage.iterations):
                step = self._step(following, target, plan, vertices, stage, firmness)
                vertices, whole = self._guarded(vertices, step, floor, firmness)
                if whole and np.abs(step).max() < 0.2 * stage.width * self.scale / 100:
                    break
        return vertices

    def _guarded(
        self, vertices: np.ndarray, step: np.ndarray, floor: np.ndarray, firmness: np.ndarray
    ) -> tuple[np.ndarray, bool]:
        """Take the step as far as no tet gets under its floor; tets that stopped it are firmer from now on."""
        share = 1.0
        while share > 1e-3:
            moved = vertices + share * step
            low = tet_volumes(moved, self.cage.tets) < floor
            if not low.any():
                return moved, share == 1.0
            firmness[low] = np.minimum(10 * firmness[low], 1e4)
            share *= 0.5
        return vertices, False

    def _step(
        self,
        following: CageSystem,
        target: Target,
        plan: Transport | None,
        vertices: np.ndarray,
        stage: Stage,
        firmness: np.ndarray,
    ) -> np.ndarray:
        """One Gauss-Newton step (c, 3) of the energy above with correspondences and weights held."""
        strength = stage.rigidity * self.scale**2 / self.system.volumes.sum() * firmness
        blocks, right = self.system.new_terms()
        for rest, share in ((following, stage.from_start), (self.system, 1 - stage.from_start)):
            if share > 0:
                rest.add_arap(blocks, right, vertices, share * strength)
        surface = self.surface_at(vertices)
        normals = vertex_normals(surface, self.faces)
        width = stage.width * self.scale
        if stage.points == "plan" and plan is not None:
            index = self.sparse
            goals, mass = plan.mean_goals(surface[index], normals[index], width, _ROUNDS)
            for axis, offsets in zip(np.eye(3), (goals - surface[index]).T, strict=True):
                self._pull(blocks, right, index, np.tile(axis, (len(index), 1)), mass, np.ascontiguousarray(offsets))
        else:
            for index, planes, weights, offsets in self._planes(target, surface, normals, stage.points, width):
                self._pull(blocks, right, index, planes, weights, offsets)
        return self.system.solve(blocks, right, 1e-7 * blocks[:, [0, 4, 8]].max())

    def _pull(
        self,
        blocks: np.ndarray,
        right: np.ndarray,
        index: np.ndarray,
        planes: np.ndarray,
        weights: np.ndarray,
        offsets: np.ndarray,
    ) -> None:
        """Add the pull of surface vertices (p,) towards planes (p, 3) at ``offsets`` (p,)."""
        tet, embedding = self.cage.tet_of_vertex[index], self.cage.weights[index]
        self.system.add_planes(blocks, right, tet, embedding, planes, weights, offsets)

    def _planes(
        self, target: Target, surface: np.ndarray, all_normals: np.ndarray, kind: str, width: float
    ) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """Each direction's data: surface vertices (p,), planes (p, 3), weights and distances to the planes (p,)."""
        index = self._dense if kind == "all" else self.samples
        points, normals = surface[index], all_normals[index]
        goals, goal_normals = target.alike(points, normals) if kind == "alike" else target.closest(points)
        shares = self._dense_shares if kind == "all" else np.full(len(index), 1 / len(index))
        forward = symmetric_planes(points, normals, goals, goal_normals, shares, width)
        # The other way round, nearest in place and direction among the surface's own vertices.
        seen, seen_normals = target.vertices[target.samples], target.normals[target.samples]
        turn = 2 * self.spacing
        tree = cKDTree(np.concatenate([points, turn * normals], axis=1), balanced_tree=False, compact_nodes=False)
        _, rank = tree.query(np.concatenate([seen, turn * seen_normals], axis=1))
        shares = np.full(len(seen), 1.0 / len(seen))
        backward = symmetric_planes(points[rank], normals[rank], seen, seen_normals, shares, width)
        return [(index, *forward), (index[rank], *backward)]


def _dense_samples(vertices: np.ndarray, areas: np.ndarray) -> np.ndarray:
    """All vertices with area, or some _DENSE of them, evenly spread, where there are more."""
    usable = np.flatnonzero(areas > 0)
    spacing = np.sqrt(areas.sum() / _DENSE)
    while len(usable) > _DENSE:
        usable = thin(vertices, areas, spacing)
        spacing *= 1.1
    return usable


def symmetric_planes(
    points: np.ndarray,
    normals: np.ndarray,
    goals: np.ndarray,
    goal_normals: np.ndarray,
    shares: np.ndarray,
    width: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Planes (p, 3) half way between two normals, their weights (p,) and the points' distances to them (p,).

    A weight is its share times Welsch's times the normals' cosine, zero where they are 60 degrees apart or more.
    """
    planes, weights, offsets = np.empty_like(points), np.empty(len(points)), np.empty(len(points))
    _native.symmetric_planes(shares, points, normals, goals, goal_normals, width, planes, weights, offsets)
    return planes, weights, offsets
