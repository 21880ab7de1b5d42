import numpy as np
from toy_pair import bending_pair, club

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.geometry.rotations import fit_planar
from unstructured_mg.synthesis.align import align_windows, vertex_areas


def test_a_moved_window_is_brought_back_exactly():
    moved = PlanarRigid(2.1, -3.0, 0.7)
    angles = np.linspace(0.1, 0.5, 7)
    pair = bending_pair(3, angles, angles, moved)
    np.testing.assert_allclose(align_windows(pair).matrix(), moved.inverse().matrix(), atol=1e-9)


def test_the_ground_holds_more_than_the_head():
    """The head leans over; evenly weighted, the feet would go back by the mean of the lean."""
    pair = bending_pair(3, np.full(7, 0.0), np.full(7, 0.8))
    masses = vertex_areas(pair.vertices[3], pair.faces)
    even = fit_planar(pair.vertices[10], pair.vertices[3], masses)
    assert abs(align_windows(pair).x) < 0.75 * abs(even.x)


def test_it_is_the_minimum_of_the_energy_as_written():
    # The lowest point of the club never touches the floor: nothing stands.
    lifted = club()
    lifted.surface[:, 2] += 0.1
    lifted.cage[:, 2] += 0.1
    pair = bending_pair(3, moved=PlanarRigid(0.4, 1.0, 2.0), template=lifted)
    source, target = pair.vertices[3], pair.vertices[10]
    masses = vertex_areas(source, pair.faces) + vertex_areas(target, pair.faces)
    heights = source[:, 2] + target[:, 2]
    weights = masses * np.exp(-(heights**2) / (2 * (masses @ heights**2) / masses.sum()))

    def energy(yaw, x, y):
        return weights @ ((source - PlanarRigid(yaw, x, y).apply(target)) ** 2).sum(1)

    found = align_windows(pair)
    best = energy(found.yaw, found.x, found.y)
    for step in np.vstack([np.eye(3), -np.eye(3)]) * 1e-4:
        assert energy(found.yaw + step[0], found.x + step[1], found.y + step[2]) > best


def test_soles_that_stand_outweigh_the_bodies():
    """One stands upright, the other leans over: even ground-weighted bodies would take its tip along."""
    pair = bending_pair(3, np.full(7, 0.0), np.full(7, 1.2), PlanarRigid(0.0, 0.3, 0.0))
    tip = pair.vertices[0, :, 2].argmin()
    brought = align_windows(pair).apply(pair.vertices[10])
    even = fit_planar(pair.vertices[10], pair.vertices[3], vertex_areas(pair.vertices[3], pair.faces))
    gaps = [np.linalg.norm((x - pair.vertices[3])[tip, :2]) for x in (brought, even.apply(pair.vertices[10]))]
    assert gaps[1] > 0.1 and gaps[0] < 0.1 * gaps[1]


def test_areas_add_up_to_the_surface():
    pair = bending_pair()
    vertices = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0], [9, 9, 9]])
    np.testing.assert_allclose(vertex_areas(vertices, np.array([[0, 1, 2]])), [1, 1, 1, 0])
    assert vertex_areas(pair.vertices[0], pair.faces).min() > 0
