import os

import numpy as np
import pytest
from tracking.bodies import figure

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.tracking.cage import build_cage
from unstructured_mg.tracking.embedding import embed, tet_rotations
from unstructured_mg.tracking.options import TrackingOptions


def test_the_cage_is_positive_fills_the_body_and_carries_its_surface(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    vertices, faces = figure(40, 60)
    cage = build_cage(TexturedMesh(vertices, faces), TrackingOptions(cage="tetwild", cage_vertices=300))
    assert cage.method == "tetwild"
    volumes = tet_volumes(cage.vertices, cage.tets)
    assert volumes.min() > 0
    corner = vertices[faces]
    solid = np.einsum("fx,fx->", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])) / 6
    np.testing.assert_allclose(volumes.sum(), solid, rtol=0.05)
    rotations = tet_rotations(cage.vertices, cage.tets, cage.vertices)
    surface = embed(cage.vertices, cage.tets, cage.tet_of_vertex, cage.weights, rotations, cage.residual)
    # Residuals below a nanometre count as none, and where tetwild puts its vertices differs from run to run.
    np.testing.assert_allclose(surface, vertices, atol=1.8e-9)
    assert np.linalg.norm(cage.residual, axis=1).max() < 0.02
    assert os.listdir(tmp_path) == []


def test_a_run_out_of_time_says_so():
    vertices, faces = figure(40, 60)
    with pytest.raises(RuntimeError, match="did not end within 0.01 s"):
        build_cage(TexturedMesh(vertices, faces), TrackingOptions(cage="tetwild", tetwild_seconds=0.01))
