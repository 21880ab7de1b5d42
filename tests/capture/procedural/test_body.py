"""The resting body: closed, on its implicit surface, well skinned, with its limbs apart."""

import numpy as np
from scipy.spatial import cKDTree

from unstructured_mg.capture.procedural.body import Implicit, reference_body
from unstructured_mg.capture.procedural.remesh import opposite_half_edges
from unstructured_mg.capture.procedural.skeleton import NAMES


def test_the_surface_is_a_closed_sphere_the_right_way_out():
    body = reference_body()
    assert (body.opposite == opposite_half_edges(body.faces)).all()
    assert len(body.vertices) - len(body.faces) // 2 == 2
    a, b, c = (body.vertices[body.faces[:, i]] for i in range(3))
    assert 0.06 < np.einsum("ij,ij->", a, np.cross(b, c)) / 6 < 0.10


def test_vertices_lie_on_the_zero_set():
    body = reference_body()
    values = np.abs(Implicit()(body.vertices))
    assert np.quantile(values, 0.99) < 0.001
    assert values.max() < 0.01  # at the hems' sharp ledges


def test_a_person_of_ordinary_height_stands_on_the_floor():
    vertices = reference_body().vertices
    assert abs(vertices[:, 2].min()) < 0.002
    assert 1.70 < vertices[:, 2].max() < 1.85
    assert np.abs(vertices[:, 2] < 0.001).sum() > 50  # soles are flat


def test_both_halves_mirror_each_other():
    vertices = reference_body().vertices
    low = vertices[vertices[:, 2] < 1.5]  # the hair is parted at one side
    distance, _ = cKDTree(low).query(low * [-1, 1, 1])
    assert np.quantile(distance, 0.95) < 0.012


def test_weights_are_a_partition_and_smooth():
    body = reference_body()
    assert (body.weights >= 0).all()
    assert np.abs(body.weights.sum(1) - 1).max() < 1e-12
    edges = np.concatenate([body.faces[:, [0, 1]], body.faces[:, [1, 2]]])
    change = np.abs(body.weights[edges[:, 0]] - body.weights[edges[:, 1]]).max(1)
    length = np.linalg.norm(body.vertices[edges[:, 0]] - body.vertices[edges[:, 1]], axis=1)
    assert (change / length).max() < 40  # no joint sharper than 2.5 cm from one bone to the next


def test_no_bone_pulls_on_another_limb():
    body = reference_body()
    left = body.vertices[:, 0] > 0.02
    for name, weight in zip(NAMES, body.weights.T, strict=True):
        if name.startswith("right_") and not name.endswith(("hip", "clavicle")):
            assert weight[left].max() < 0.02
    arms = np.abs(body.vertices[:, 0]) > 0.35
    legs = [i for i, name in enumerate(NAMES) if name.split("_")[-1] in ("hip", "knee", "ankle", "toe")]
    assert body.weights[arms][:, legs].max() == 0


def test_shade_is_a_share():
    shade = reference_body().shade
    assert shade.min() >= 0
    assert shade.max() <= 1
    assert shade.mean() > 0.6
