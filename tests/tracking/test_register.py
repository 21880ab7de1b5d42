import numpy as np
from scipy.spatial.transform import Rotation
from tracking.bodies import bend, figure

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.tracking.cage import build_cage
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.register import Registrar, far_stages, near_stages, symmetric_planes
from unstructured_mg.tracking.surface import clean_surface

OPTIONS = TrackingOptions(cage_vertices=400)


def registrar(vertices, faces):
    return Registrar(clean_surface(vertices, faces), build_cage(TexturedMesh(vertices, faces), OPTIONS))


def test_a_rigid_motion_is_recovered_on_another_mesh_of_the_body():
    source, target = figure(40, 60), figure(53, 71)
    turn = Rotation.from_rotvec([0.02, 0.01, 0.08]).as_matrix()

    def move(points):
        return points @ turn.T + [0.05, -0.03, 0.01]

    tracked = registrar(*source)
    goal = tracked.target(clean_surface(move(target[0]), target[1]))
    reached = tracked.surface_at(tracked.register(goal, tracked.cage.vertices, near_stages(1e-4)))
    assert np.linalg.norm(reached - move(source[0]), axis=1).max() < 2e-3


def test_a_bend_is_recovered_on_another_mesh_of_the_body():
    source, target = figure(40, 60), figure(53, 71)
    tracked = registrar(*source)
    goal = tracked.target(clean_surface(bend(target[0], 0.6), target[1]))
    cage = tracked.register(goal, tracked.cage.vertices, far_stages(1e-4))
    error = np.linalg.norm(tracked.surface_at(cage) - bend(source[0], 0.6), axis=1)
    before = np.linalg.norm(source[0] - bend(source[0], 0.6), axis=1)
    assert before.max() > 0.3
    assert np.sqrt(np.mean(error**2)) < 6e-3 and error.max() < 2e-2
    assert tet_volumes(cage, tracked.cage.tets).min() > 0


def test_the_same_input_gives_the_same_bytes():
    source, target = figure(40, 60), figure(53, 71)
    results = []
    for _ in range(2):
        tracked = registrar(*source)
        goal = tracked.target(clean_surface(bend(target[0], 0.2), target[1]))
        results.append(tracked.register(goal, tracked.cage.vertices, near_stages(1e-4)).tobytes())
    assert results[0] == results[1]


def test_far_limbs_find_their_place_where_the_nearest_surface_is_another_limbs():
    # Two upright tubes side by side; the second moves away so far that the first is nearer to where it was than itself.
    vertices, faces = figure(30, 40)
    target, target_faces = figure(37, 46)
    both = np.concatenate([vertices * [0.4, 0.4, 0.6], vertices * [0.4, 0.4, 0.6] + [0.2, 0, 0]])
    moved = np.concatenate([vertices * [0.4, 0.4, 0.6] + [0.12, 0, 0], vertices * [0.4, 0.4, 0.6] + [0.6, 0, 0]])
    goal = np.concatenate([target * [0.4, 0.4, 0.6] + [0.12, 0, 0], target * [0.4, 0.4, 0.6] + [0.6, 0, 0]])
    tracked = registrar(both, np.concatenate([faces, faces + len(vertices)]).astype(np.int32))
    goal_faces = np.concatenate([target_faces, target_faces + len(target)]).astype(np.int32)
    aim = tracked.target(clean_surface(goal, goal_faces))
    start = tracked.cage.vertices
    assert tracked.gap(aim, start) > 0.15
    reached = tracked.surface_at(tracked.register(aim, start, tracked.stages(aim, start, 1e-4)))
    assert np.linalg.norm(reached - moved, axis=1).max() < 5e-3


def test_planes_lie_half_way_between_the_normals_and_count_by_nearness_and_agreement():
    rng = np.random.default_rng(5)
    points, goals = rng.normal(size=(2, 400, 3))
    normals, goal_normals = (rng.normal(size=(400, 3)) for _ in range(2))
    goal_normals += 2 * normals
    normals, goal_normals = (n / np.linalg.norm(n, axis=1, keepdims=True) for n in (normals, goal_normals))
    shares, width = rng.random(400), 0.8
    planes, weights, offsets = symmetric_planes(points, normals, goals, goal_normals, shares, width)
    middle = normals + goal_normals
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    away = goals - points
    cosine, squared = (normals * goal_normals).sum(1), (away**2).sum(1)
    wanted = np.where((cosine > 0.5) & (squared < 13.8 * width**2), shares * np.exp(-squared / width**2) * cosine, 0)
    assert 50 < np.count_nonzero(wanted) < 350
    np.testing.assert_allclose(planes, middle, atol=1e-12)
    np.testing.assert_allclose(weights, wanted, rtol=1e-12)
    np.testing.assert_allclose(offsets, (middle * away).sum(1), atol=1e-12)
