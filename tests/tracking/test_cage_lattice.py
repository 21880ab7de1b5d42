import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from tracking.bodies import figure, tube

from unstructured_mg.geometry.components import face_components
from unstructured_mg.geometry.tets import barycentric, tet_volumes
from unstructured_mg.tracking.cage_lattice import lattice_cage


def pieces(tets, count):
    links = np.concatenate([tets[:, [0, 1]], tets[:, [1, 2]], tets[:, [2, 3]]])
    return connected_components(coo_matrix((np.ones(len(links)), links.T), (count, count)), directed=False)


def test_every_vertex_lies_in_its_cell_and_cells_are_positive_and_different():
    vertices, faces = figure(40, 60)
    cage, tets, tet_of_vertex = lattice_cage(vertices, faces, 0.08)
    assert barycentric(cage, tets, vertices, tet_of_vertex).min() > -1e-9
    np.testing.assert_allclose(tet_volumes(cage, tets), 0.08**3 / 12, rtol=1e-9)
    assert len(np.unique(np.sort(tets, axis=1), axis=0)) == len(tets)
    assert pieces(tets, len(cage))[0] == 1


def test_the_cage_of_a_solid_body_is_filled_and_no_cell_is_there_twice():
    vertices, faces = figure(40, 60)
    cage, tets, _ = lattice_cage(vertices, faces, 0.08)
    centres = np.round(cage[tets].mean(1), 6)
    assert len(np.unique(centres, axis=0)) == len(tets)
    # A filled cage is a ball: Euler characteristic 1 over its vertices, edges, triangles and tets.
    edges = np.unique(np.sort(tets[:, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]].reshape(-1, 2), 1), axis=0)
    sides = np.unique(np.sort(tets[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3), 1), axis=0)
    assert len(np.unique(tets)) - len(edges) + len(sides) - len(tets) == 1


def test_two_near_tubes_share_no_cell_however_coarse_the_lattice():
    vertices, faces = tube(0.05, 0.6, 24, 40)
    both = np.concatenate([vertices, vertices + [0.0, 0.105, 0.0]])
    both_faces = np.concatenate([faces, faces + len(vertices)])
    cage, tets, tet_of_vertex = lattice_cage(both, both_faces, 0.12)
    count, label = pieces(tets, len(cage))
    assert count == 2
    part = label[tets[tet_of_vertex, 0]]
    assert len(set(part[: len(vertices)])) == len(set(part[len(vertices) :])) == 1
    assert part[0] != part[-1]


def test_a_hairpin_is_joined_only_at_its_bend():
    # A tube folded back on itself: its legs are 5 mm apart, 0.05 of a cell, and far apart along the surface.
    vertices, faces = tube(0.05, 1.2, 24, 90)
    radius, angle = 0.0525, np.clip(vertices[:, 0] / 0.0525, -np.pi / 2, np.pi / 2)
    beyond = vertices[:, 0] - angle * radius
    off = radius + vertices[:, 1]
    folded = np.stack([off * np.cos(angle) - np.abs(beyond), off * np.sin(angle), vertices[:, 2]], axis=1)
    # Bending leaves the inner side where the fold's axis is; keep it from folding over.
    folded[:, 1] = np.where(np.abs(folded[:, 1]) < 0.0025, np.sign(angle + 1e-9) * 0.0025, folded[:, 1])
    # The fold maps (x, y, z) to a left-handed frame.
    cage, tets, tet_of_vertex = lattice_cage(folded, faces[:, ::-1].copy(), 0.1)
    one = (vertices[:, 0] > 0.25) & (vertices[:, 0] < 0.6)
    other = (vertices[:, 0] < -0.25) & (vertices[:, 0] > -0.6)
    assert not set(tet_of_vertex[one]) & set(tet_of_vertex[other])
    assert not set(tets[tet_of_vertex[one]].ravel()) & set(tets[tet_of_vertex[other]].ravel())
    assert pieces(tets, len(cage))[0] == 1


def test_an_open_sheet_gets_a_cage_around_it_in_one_piece():
    grid = np.stack(np.meshgrid(np.linspace(0, 1, 30), np.linspace(0, 0.6, 20), indexing="ij"), -1).reshape(-1, 2)
    vertices = np.concatenate([grid, 0.1 * np.sin(4 * grid[:, :1])], axis=1)
    i, j = np.meshgrid(np.arange(29), np.arange(19), indexing="ij")
    a = (20 * i + j).ravel()
    faces = np.concatenate([np.stack([a, a + 20, a + 21], 1), np.stack([a, a + 21, a + 1], 1)]).astype(np.int32)
    assert face_components(len(vertices), faces).max() == 0
    cage, tets, tet_of_vertex = lattice_cage(vertices, faces, 0.08)
    assert barycentric(cage, tets, vertices, tet_of_vertex).min() > -1e-9
    assert pieces(tets, len(cage))[0] == 1


def test_the_same_input_gives_the_same_bytes():
    vertices, faces = figure(30, 40)
    first, second = (lattice_cage(vertices, faces, 0.09) for _ in range(2))
    for one, other in zip(first, second, strict=True):
        assert one.tobytes() == other.tobytes()
