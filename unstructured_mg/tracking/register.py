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

from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.tracking.embedding import Cage, embed
from unstructured_mg.tracking.surface import CleanSurface, unit, vertex_areas, vertex_normals
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
        self._corners = cage.tets[cage.tet_of_vertex]

    def target(self, surface: CleanSurface) -> Target:
        """Prepare a frame as a target for this surface."""
        return Target(surface, self.spacing, self.spacing * SPARSER)

    def is_near(self, target: Target, start: np.ndarray) -> bool:
        """Whether the target is so close to the surface at ``start`` (c, 3) that limbs cannot be mistaken."""
        surface = self.surface_at(start)
        points = surface[self.samples]
        goals, _ = target.alike(points, vertex_normals(surface, self.faces)[self.samples])
        return float(np.percentile(np.linalg.norm(goals - points, axis=1), 99)) < _NEAR * self.scale

    def surface_at(self, cage_vertices: np.ndarray) -> np.ndarray:
        """The carried surface (n, 3) at given cage vertices (c, 3)."""
        cage = self.cage
        if not cage.residual.any():
            return np.einsum("ni,nix->nx", cage.weights, cage_vertices[self._corners])
        _, rotations = self.system.rotations(cage_vertices)
        return embed(cage_vertices, cage.tets, cage.tet_of_vertex, cage.weights, rotations, cage.residual)

    def stages(self, target: Target, start: np.ndarray, rigidity: float) -> list[Stage]:
        """The annealing that suits the distance between the surface at ``start`` (c, 3) and the target."""
        return near_stages(rigidity) if self.is_near(target, start) else far_stages(rigidity)

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
        system = self.system
        blocks, right = system.new_blocks(), np.zeros_like(vertices)
        for rest, share in ((following, stage.from_start), (system, 1 - stage.from_start)):
            if share > 0:
                linear, rotations = rest.rotations(vertices)
                rest.add_arap(blocks, rotations, share * strength)
                right -= rest.arap_gradient(linear, rotations, share * strength)
        surface = self.surface_at(vertices)
        normals = vertex_normals(surface, self.faces)
        width = stage.width * self.scale
        if stage.points == "plan" and plan is not None:
            index = self.sparse
            goals, mass = plan.mean_goals(surface[index], normals[index], width, _ROUNDS)
            for axis in range(3):
                planes = np.zeros((len(index), 3))
                planes[:, axis] = 1.0
                right += self._add(system, blocks, index, planes, mass, (goals - surface[index])[:, axis])
        else:
            right += self._add(system, blocks, *self._planes(target, surface, normals, stage.points, width))
        return system.solve(blocks, right, 1e-7 * blocks[:, [0, 4, 8]].max())

    def _add(
        self,
        system: CageSystem,
        blocks: np.ndarray,
        index: np.ndarray,
        planes: np.ndarray,
        weights: np.ndarray,
        offsets: np.ndarray,
    ) -> np.ndarray:
        """Add the pull of surface vertices (p,) towards planes at ``offsets`` (p,); returns the right side (c, 3)."""
        tet, embedding = self.cage.tet_of_vertex[index], self.cage.weights[index]
        system.add_planes(blocks, tet, embedding, planes, weights)
        pull = (weights * offsets)[:, None, None] * embedding[:, :, None] * planes[:, None, :]
        return system.scatter(self.cage.tets[tet], pull)

    def _planes(
        self, target: Target, surface: np.ndarray, all_normals: np.ndarray, kind: str, width: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Both directions' data: surface vertices (p,), planes (p, 3), weights and distances to the planes (p,)."""
        index = self._dense if kind == "all" else self.samples
        points, normals = surface[index], all_normals[index]
        goals, goal_normals = target.alike(points, normals) if kind == "alike" else target.closest(points)
        shares = self._dense_shares if kind == "all" else np.full(len(index), 1 / len(index))
        forward = _planes(points, normals, goals, goal_normals, shares, width)
        # The other way round, nearest in place and direction among the surface's own vertices.
        seen, seen_normals = target.vertices[target.samples], target.normals[target.samples]
        turn = 2 * self.spacing
        tree = cKDTree(np.concatenate([points, turn * normals], axis=1), balanced_tree=False, compact_nodes=False)
        _, rank = tree.query(np.concatenate([seen, turn * seen_normals], axis=1))
        shares = np.full(len(seen), 1.0 / len(seen))
        backward = _planes(points[rank], normals[rank], seen, seen_normals, shares, width)
        carrier = np.concatenate([index, index[rank]])
        planes, weights, offsets = (np.concatenate(pair) for pair in zip(forward, backward, strict=True))
        used = weights > 1e-6 * weights.max()
        return carrier[used], planes[used], weights[used], offsets[used]


def _dense_samples(vertices: np.ndarray, areas: np.ndarray) -> np.ndarray:
    """All vertices with area, or some _DENSE of them, evenly spread, where there are more."""
    usable = np.flatnonzero(areas > 0)
    spacing = np.sqrt(areas.sum() / _DENSE)
    while len(usable) > _DENSE:
        usable = thin(vertices, areas, spacing)
        spacing *= 1.1
    return usable


def _planes(
    points: np.ndarray,
    normals: np.ndarray,
    goals: np.ndarray,
    goal_normals: np.ndarray,
    shares: np.ndarray,
    width: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Symmetric planes (p, 3), their weights (p,) and the points' distances to them (p,)."""
    away = goals - points
    cosine = np.einsum("ix,ix->i", normals, goal_normals)
    weights = shares * np.exp(-np.einsum("ix,ix->i", away, away) / width**2) * np.where(cosine > 0.5, cosine, 0.0)
    planes = unit(normals + goal_normals)
    return planes, weights, np.einsum("ix,ix->i", planes, away)
