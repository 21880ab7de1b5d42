import numpy as np
import pytest
import trimesh
from array_capture import figure

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.matching.extent import actor_size, extent


def test_a_ball_has_its_centre_radius_and_heights():
    ball = trimesh.creation.icosphere(4, radius=0.5)
    found = extent(TexturedMesh(ball.vertices + [2.0, -1.0, 0.75], ball.faces.astype(np.int32)))
    np.testing.assert_allclose(found, [2.0, -1.0, 0.5, 0.25, 1.25], atol=0.01)
    assert actor_size(found[None]) == pytest.approx(1.0, abs=0.02)


def test_debris_does_not_count():
    vertices, faces = figure(0.3, seed=1)
    speck = trimesh.creation.icosphere(1, radius=0.01)
    debris = (
        np.concatenate([vertices, speck.vertices + [40, 0, 30]]),
        np.concatenate([faces, speck.faces + len(vertices)]),
    )
    found = [extent(TexturedMesh(v, np.asarray(f, np.int32))) for v, f in ((vertices, faces), debris)]
    np.testing.assert_allclose(found[0][2:], found[1][2:], atol=0.06)


def test_a_surface_without_area_is_refused():
    with pytest.raises(ValueError, match="mesh: expected a surface"):
        extent(TexturedMesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32)))
