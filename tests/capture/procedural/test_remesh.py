"""Re-meshing: manifold and genus kept, Delaunay-like, another mesh for another seed."""

import igl
import numpy as np
import pytest

from unstructured_mg.capture.procedural.remesh import coarsen, flip_edges, opposite_half_edges, remesh
from unstructured_mg.geometry.closest import ClosestPoints


def ring(major=0.4, minor=0.15, around=96, across=48):
    """A torus: its genus must survive."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u.ravel() / around, 2 * np.pi * v.ravel() / across
    radius = major + minor * np.cos(b)
    vertices = np.stack([radius * np.cos(a), radius * np.sin(a), minor * np.sin(b)], 1)

    def index(i, j):
        return (i % around) * across + j % across

    p, q, r, s = index(u, v), index(u + 1, v), index(u + 1, v + 1), index(u, v + 1)
    faces = np.concatenate([np.stack([p, q, r], -1).reshape(-1, 3), np.stack([p, r, s], -1).reshape(-1, 3)])
    return vertices, np.ascontiguousarray(faces, np.int32)


def euler(faces):
    return len(np.unique(faces)) - len(faces) // 2


def test_opposite_half_edges_against_a_dictionary():
    _, faces = ring(around=12, across=7)
    opposite = opposite_half_edges(faces)
    edges = {(f[c], f[(c + 1) % 3]): 3 * i + c for i, f in enumerate(faces.tolist()) for c in range(3)}
    assert opposite.tolist() == [edges[f[(c + 1) % 3], f[c]] for f in faces.tolist() for c in range(3)]


@pytest.mark.parametrize("spoil", ["open", "turned"])
def test_what_is_not_a_closed_oriented_manifold_is_refused(spoil):
    _, faces = ring(around=12, across=7)
    faces = faces[1:] if spoil == "open" else np.concatenate([faces[:1, ::-1], faces[1:]])
    with pytest.raises(ValueError, match="closed"):
        opposite_half_edges(faces)


def test_coarsening_keeps_a_closed_manifold_of_the_same_genus():
    vertices, faces = ring()
    before = faces.copy()
    opposite = opposite_half_edges(faces)
    sizes = np.full(len(vertices), 0.05)
    kept, coarse = coarsen(faces, opposite, vertices, sizes, 7, 1200)
    assert (faces == before).all()
    assert len(coarse) == 1200
    assert sorted(np.unique(coarse)) == list(range(len(kept)))
    opposite_half_edges(coarse)
    assert euler(coarse) == 0
    a, b, c = (vertices[kept][coarse[:, i]] for i in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert volume == pytest.approx(2 * np.pi**2 * 0.4 * 0.15**2, rel=0.05)


def test_flips_reach_the_delaunay_condition_and_keep_the_table():
    vertices, faces = ring()
    kept, faces = coarsen(faces, opposite_half_edges(faces), vertices, np.full(len(vertices), 0.05), 3, 2000)
    points = vertices[kept]
    opposite = opposite_half_edges(faces)
    assert flip_edges(faces, opposite, points, 50) > 0
    assert (opposite == opposite_half_edges(faces)).all()
    assert euler(faces) == 0
    angles = igl.internal_angles(points, faces)
    facing = np.roll(angles, 1, axis=1).ravel()  # the angle opposite half-edge c -> c + 1
    over = facing + facing[opposite] > np.pi + 1e-6
    assert over.mean() < 0.002  # only where a flip would fold the surface


def test_a_remeshing_lies_on_the_surface_and_differs_by_seed():
    vertices, faces = ring()
    surface, opposite = ClosestPoints(vertices, faces), opposite_half_edges(faces)
    sizes = np.full(len(vertices), 0.05)
    first, again, second = (remesh(surface, opposite, sizes, seed, 1500) for seed in (1, 1, 2))
    for one, other in zip(first, again, strict=True):
        assert one.tobytes() == other.tobytes()
    assert first[0].shape != second[0].shape or (first[0] != second[0]).any()
    new_faces, face, weights = first
    opposite_half_edges(new_faces)
    assert euler(new_faces) == 0
    points = np.einsum("pk,pki->pi", weights, vertices[faces[face]])
    assert np.abs(surface.query(points)[0]).max() < 1e-18
    # Well-shaped: the mean smallest angle of an equilateral mesh is 60 degrees.
    assert np.degrees(igl.internal_angles(points, new_faces).min(1)).mean() > 38
