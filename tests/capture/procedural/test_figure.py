"""The procedural figure's frames: closed, of new connectivity, and true to the reference surface."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from unstructured_mg.capture.procedural import ProceduralCapture
from unstructured_mg.capture.procedural.remesh import opposite_half_edges
from unstructured_mg.geometry.closest import ClosestPoints


@pytest.fixture(scope="module")
def capture():
    return ProceduralCapture(frames=240, faces=4000, texture_size=256)


@pytest.fixture(scope="module")
def meshes(capture):
    return {frame: capture.frame_mesh(frame) for frame in (0, 25, 72, 173)}


def test_frames_are_closed_spheres_of_the_asked_size(meshes):
    for mesh in meshes.values():
        opposite_half_edges(mesh.faces)  # raises unless closed, manifold and consistently oriented
        edges = len(mesh.faces) * 3 // 2
        assert len(mesh.vertices) - edges + len(mesh.faces) == 2
        assert len(np.unique(mesh.faces)) == len(mesh.vertices)
        assert 0.9 * 4000 <= len(mesh.faces) <= 1.1 * 4000
        a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
        assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(0.08, abs=0.02)  # a person's litres


def test_vertices_lie_on_the_true_surface_exactly(capture, meshes):
    for frame, mesh in meshes.items():
        assert (mesh.material_weights >= 0).all()
        assert np.abs(mesh.material_weights.sum(1) - 1).max() < 1e-12
        there = capture.material_positions(mesh.material_face, mesh.material_weights, frame)
        assert np.abs(there - mesh.vertices).max() < 1e-12
        vertices, faces = capture.true_surface(frame)
        squared, _, _ = ClosestPoints(vertices, faces).query(mesh.vertices)
        assert np.sqrt(squared.max()) < 1e-9


def test_flat_triangles_stay_near_the_true_surface(capture, meshes):
    # Between its vertices a triangle leaves the curved surface by about edge^2 / (8 radius), some millimetres.
    for frame, mesh in meshes.items():
        vertices, faces = capture.true_surface(frame)
        centres = mesh.vertices[mesh.faces].mean(1)
        squared, _, _ = ClosestPoints(vertices, faces).query(centres)
        assert np.sqrt(squared.mean()) < 0.004
        assert np.sqrt(squared.max()) < 0.03


def test_every_frame_has_another_connectivity_and_atlas(meshes):
    edge_sets, points = [], []
    for mesh in meshes.values():
        points.append(np.sort(mesh.material_face))
        edge_sets.append((len(mesh.vertices), len(mesh.faces), mesh.faces[:50].tobytes()))
    assert len(set(edge_sets)) == len(edge_sets)
    # As material points hardly any vertex recurs, so no edge does.
    keys = [np.column_stack([m.material_face, np.round(m.material_weights, 6)]) for m in meshes.values()]
    for i, first in enumerate(keys):
        for second in keys[i + 1 :]:
            distance, _ = cKDTree(first).query(second)
            assert (distance < 1e-5).mean() < 0.02


def test_a_longer_capture_starts_with_the_same_frames(capture, meshes):
    longer = ProceduralCapture(frames=300, faces=4000, texture_size=256).frame_mesh(72)
    assert longer.vertices.tobytes() == meshes[72].vertices.tobytes()
    assert longer.faces.tobytes() == meshes[72].faces.tobytes()
    assert longer.pixels.tobytes() == meshes[72].pixels.tobytes()


def test_the_same_material_point_has_the_same_colour_in_every_frame(capture, meshes):
    """Look the colour of material points up in two frames' atlases: paint sticks to the body."""
    first, second = meshes[0], meshes[173]
    body = capture.body

    def colours(mesh, points):
        resting = np.einsum("pk,pki->pi", mesh.material_weights, body.vertices[body.faces[mesh.material_face]])
        surface = ClosestPoints(resting, mesh.faces)
        _, face, closest = surface.query(points)
        weights = surface.barycentric(face, closest)
        uv = np.einsum("pk,pki->pi", weights, mesh.uv[mesh.face_uv[face]])
        size = len(mesh.pixels)
        column = np.clip((uv[:, 0] * size).astype(int), 0, size - 1)
        row = np.clip(((1 - uv[:, 1]) * size).astype(int), 0, size - 1)
        return mesh.pixels[row, column].astype(float)

    points = body.vertices[::20]
    difference = np.abs(colours(first, points) - colours(second, points)).max(1)
    assert np.median(difference) <= 6
    assert (difference > 60).mean() < 0.10  # only where a texel straddles a printed edge


@pytest.mark.parametrize(
    "bad", [{"frames": 0}, {"faces": 10}, {"texture_size": 8}, {"seed": -1}], ids=lambda bad: next(iter(bad))
)
def test_bad_arguments_are_named(bad):
    with pytest.raises(ValueError, match=next(iter(bad))):
        ProceduralCapture(**bad)


def test_a_frame_out_of_range_is_an_error(capture):
    with pytest.raises(ValueError, match="frame"):
        capture.true_surface(240)
