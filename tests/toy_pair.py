"""A tracked pair with known motion: an upright club on the floor, bent along circles, in a lattice cage."""

import itertools

import numpy as np
import trimesh

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.geometry.tets import barycentric, tet_volumes
from unstructured_mg.synthesis.posture import Template
from unstructured_mg.tracking.pair import TrackedPair


def lattice(*axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and positively oriented tets of a box of cells, each cut into six along its diagonal (Kuhn)."""
    shape = tuple(len(axis) for axis in axes)
    vertices = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    corner = np.stack(np.meshgrid(*[np.arange(n - 1) for n in shape], indexing="ij"), -1).reshape(-1, 3)
    tets = []
    for order in itertools.permutations(np.eye(3, dtype=int)):
        path = np.cumsum([np.zeros(3, int), *order], axis=0)
        tets.append(np.stack([np.ravel_multi_index((corner + step).T, shape) for step in path], axis=1))
    tets = np.concatenate(tets).astype(np.int32)
    flipped = tet_volumes(vertices, tets) < 0
    tets[flipped] = tets[flipped][:, [0, 1, 3, 2]]
    return vertices, tets


def club() -> Template:
    """One metre high, 0.2 m thick, standing on the floor; about a third of the surface lies outside the cage."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    surface = np.asarray(ball.vertices) * [0.1, 0.1, 0.5] + [0, 0, 0.5]
    axes = (np.linspace(-0.1, 0.1, 4), np.linspace(-0.1, 0.1, 4), np.linspace(0.02, 1.0, 13))
    cage, tets = lattice(*axes)
    distances = np.linalg.norm(cage[tets].mean(1)[None] - surface[:, None], axis=2)
    tet_of_vertex = distances.argmin(1).astype(np.int32)
    weights = barycentric(cage, tets, surface, tet_of_vertex)
    frames = np.stack([bend(surface, angle) for angle in np.linspace(-0.5, 1.5, 21)])
    return Template(surface, np.asarray(ball.faces, np.int32), cage, tets, tet_of_vertex, weights, frames)


def bend(points: np.ndarray, angle: float) -> np.ndarray:
    """Bend upright points about the y axis: the line x = y = 0 keeps its length and is turned by ``angle`` at z = 1."""
    if angle == 0:
        return points.copy()
    turn, radius = points[:, 2] * angle, 1 / angle - points[:, 0]
    return np.stack([1 / angle - radius * np.cos(turn), points[:, 1], radius * np.sin(turn)], axis=1)


def bending_pair(
    k: int = 3,
    source_angles: np.ndarray | None = None,
    target_angles: np.ndarray | None = None,
    moved: PlanarRigid | None = None,
    template: Template | None = None,
) -> TrackedPair:
    """Windows that bend through the given angles (radians, 2k+1 each); the target is ``moved`` from the source."""
    template = template or club()
    half = 2 * k + 1
    source_angles = np.linspace(0.1, 0.3, half) if source_angles is None else source_angles
    target_angles = np.linspace(0.3, 0.6, half) if target_angles is None else target_angles
    moved = moved or PlanarRigid()

    def frames(points: np.ndarray) -> np.ndarray:
        source = [bend(points, angle) for angle in source_angles]
        return np.stack(source + [moved.apply(bend(points, angle)) for angle in target_angles])

    vertices, cage = frames(template.surface), frames(template.cage)
    return TrackedPair(
        source=k,
        target=100 + k,
        k=k,
        frames=np.concatenate([np.arange(half), 100 + np.arange(half)]).astype(np.int32),
        template=k,
        vertices=vertices,
        faces=template.faces,
        uv=np.zeros((0, 2)),
        face_uv=np.zeros((0, 3), np.int32),
        face_material=None,
        cage_vertices=cage,
        tets=template.tets,
        tet_of_vertex=template.tet_of_vertex,
        weights=template.weights,
        residual=np.zeros_like(vertices),
        yaw=0.0,
        measures={},
    )
