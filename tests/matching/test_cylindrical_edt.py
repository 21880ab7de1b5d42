import numpy as np
import pytest
import trimesh
from array_capture import array_capture, figure
from toy_capture import toy_capture

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.closest import ClosestPoints
from unstructured_mg.matching.cylindrical_edt import Cylinder, describe, fit, sample
from unstructured_mg.matching.extent import extent


def grid_points(cylinder):
    radius = (np.arange(cylinder.radii) + 0.5)[:, None, None] * cylinder.radius_step
    height = (cylinder.bottom + np.arange(cylinder.heights) * cylinder.height_step)[None, :, None]
    angle = 2 * np.pi * np.arange(cylinder.angles) / cylinder.angles
    coordinates = np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), height)
    return np.stack(coordinates, axis=-1)


def cylinder_of(*meshes, resolution=64):
    return fit(array_capture(meshes), np.stack([extent(TexturedMesh(*mesh)) for mesh in meshes]), resolution)


def test_distances_are_those_of_an_exact_search():
    vertices, faces = figure(0.4, seed=0)
    cylinder = cylinder_of((vertices, faces))
    square = sample(vertices, faces, cylinder)[1]
    exact = ClosestPoints(vertices, faces).query(grid_points(cylinder).reshape(-1, 3))[0].reshape(square.shape)
    error = np.sqrt(square) - np.sqrt(exact)
    assert error.min() > -1e-5  # never too small but for rounding
    near = exact < (3 * cylinder.height_step) ** 2
    assert error[near].mean() < 0.3e-3 and error[near].max() < cylinder.height_step / 2
    assert error[~near].mean() < 2e-3 and error[~near].max() < cylinder.height_step


def test_large_triangles_and_a_surface_off_the_axis():
    box = trimesh.creation.box((0.3, 0.2, 0.5))
    vertices, faces = box.vertices + [0.5, 0.2, 0.4], box.faces
    cylinder = Cylinder(16, 32, 64, 0.05, -0.1, 0.04)
    indicator, square, _ = sample(vertices, faces, cylinder)
    exact = ClosestPoints(vertices, faces).query(grid_points(cylinder).reshape(-1, 3))[0].reshape(square.shape)
    assert np.abs(np.sqrt(square) - np.sqrt(exact)).max() < 0.02
    assert indicator.sum() == pytest.approx(1, abs=1e-5)


def test_the_measure_has_the_moments_of_the_surface():
    vertices, faces = figure(1.0, seed=1)
    cylinder = cylinder_of((vertices, faces))
    indicator = sample(vertices, faces, cylinder)[0].astype(float)
    points = grid_points(cylinder)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    area /= area.sum()
    # The mean of a quadratic over a triangle is its mean over the mid-points of the edges.
    middles = np.stack([(a + b) / 2, (b + c) / 2, (c + a) / 2])
    for power in ((0, 0, 1), (0, 0, 2), (1, 0, 0), (0, 1, 0), (2, 0, 0), (1, 1, 0), (1, 0, 1)):
        true = np.einsum("f,cf->", area / 3, np.prod(middles**power, axis=2))
        found = (indicator * np.prod(points**power, axis=3)).sum()
        assert found == pytest.approx(true, abs=2e-4), power


def test_only_the_surface_counts_not_its_triangles():
    vertices, faces = figure(0.4, seed=2)
    fine = trimesh.remesh.subdivide(vertices, faces)
    doubled = (vertices, np.concatenate([faces, faces[:, ::-1]]))
    uneven = trimesh.remesh.subdivide(vertices, faces, face_index=np.arange(0, len(faces), 3))
    cylinder = cylinder_of((vertices, faces))
    base = sample(vertices, faces, cylinder)
    for other in (fine, doubled, uneven):
        indicator, square, _ = sample(*other, cylinder)
        difference = np.sum((base[0] - indicator) * (square - base[1]), dtype=np.float64) / 2
        cross = np.sum(base[0] * square + indicator * base[1], dtype=np.float64) / 2
        own = np.sum(base[0] * base[1] + indicator * square, dtype=np.float64) / 2
        assert cross - own == pytest.approx(difference, abs=1e-9)
        assert cross - own < 0.5e-3**2


def test_a_frames_own_score_is_nearly_nothing():
    vertices, faces = figure(0.4, seed=3)
    mesh = TexturedMesh(vertices, faces)
    cylinder = cylinder_of((vertices, faces))
    described, own = describe(array_capture([(vertices, faces)]), 0, extent(mesh), cylinder)
    assert described.shape == (128, 32 * 64) and described.dtype == np.complex64
    left, right = described[:64], described[64:]
    assert 0 <= own < 4e-3**2 < (cylinder.height_step / 6) ** 2
    total = (left * right).sum(axis=1).real
    assert (total[0] + 2 * total[1:].sum()) / 128 == pytest.approx(own, abs=1e-6)


def test_the_cylinder_holds_every_frame_and_no_debris():
    low, high = figure(0.0, seed=4), figure(1.5, position=(3, -2, 0.4), seed=5)
    cylinder = cylinder_of(low, high)
    top = cylinder.bottom + (cylinder.heights - 1) * cylinder.height_step
    assert cylinder.bottom < 0 and 2.15 < top < 2.5
    speck = trimesh.creation.icosphere(1, radius=0.01)
    vertices = np.concatenate([low[0], speck.vertices + [40, 0, 30]])
    faces = np.concatenate([low[1], speck.faces + len(low[0])])
    with_debris = cylinder_of((vertices, faces), high)
    assert with_debris.radius_step == pytest.approx(cylinder.radius_step, rel=0.1)
    assert with_debris.height_step == pytest.approx(cylinder.height_step, rel=0.1)
    indicator, square, _ = sample(vertices, faces, with_debris)
    assert np.isfinite(square).all() and indicator.sum() == pytest.approx(1, abs=1e-5)


@pytest.mark.parametrize(
    ("vertices", "faces", "named"),
    [
        (np.full((3, 3), np.nan), [[0, 1, 2]], "vertices"),
        (np.eye(3), [[0, 1, 3]], "faces"),
        (np.eye(3), [[-1, 1, 2]], "faces"),
        (np.eye(3), np.zeros((0, 3)), "faces"),
    ],
)
def test_what_would_crash_is_named(vertices, faces, named):
    with pytest.raises(ValueError, match=f"{named}: expected"):
        sample(vertices, np.array(faces, np.int32), Cylinder(16, 32, 64, 0.05, -0.1, 0.04))


def coloured(phase, turned, seed):
    """A figure that is bright on one side of the room, or, turned, on the other."""
    vertices, faces = figure(phase, seed=seed)
    side = vertices[:, 0] < 0 if turned else vertices[:, 0] > 0
    return TexturedMesh(vertices, faces, colors=np.where(side[:, None], 255, 51).astype(np.uint8).repeat(3, axis=1))


def test_with_colour_the_score_is_a_distance_in_space_and_colour(tmp_path):
    """The mean over both surfaces of |x - y|^2 + lambda^2 |c(x) - c(y)|^2, y the nearest point of the other surface."""
    meshes = [coloured(0.2, False, 1), coloured(0.35, True, 2)]
    capture = toy_capture(2, mesh_of=meshes.__getitem__)
    extents = np.stack([extent(mesh) for mesh in meshes])
    plain, colourful = (fit(capture, extents, 64, colour) for colour in (0.0, 0.1))
    squares = []
    for cylinder in (plain, colourful):
        (first, own_first), (second, own_second) = (describe(capture, i, extents[i], cylinder) for i in (0, 1))
        assert first.shape == second.shape == (128, 32 * 64 * (7 if cylinder.colour else 4) // 4)
        form = ((first[:64] * second[64:]).sum(axis=1) + (second[:64] * first[64:]).sum(axis=1).conj()) / 2
        total = (form[0] + 2 * form[1:].sum()).real / 128
        squares.append(total - (own_first + own_second) / 2)
    expected = []
    for one, other, place in ((meshes[0], meshes[1], extents), (meshes[1], meshes[0], extents[::-1])):
        shift = np.array([*(place[1] - place[0])[:2], 0])
        corners = one.vertices[one.faces]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        nearest = ClosestPoints(other.vertices, other.faces).query(corners.mean(axis=1) + shift)[1]
        colours = [mesh.colors[mesh.faces, 0].mean(axis=1) / 255 for mesh in (one, other)]
        expected.append(area @ (3 * 0.1**2 * (colours[0] - colours[1][nearest]) ** 2) / area.sum())
    assert squares[1] - squares[0] == pytest.approx(np.mean(expected), rel=0.1)
