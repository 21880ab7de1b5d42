from dataclasses import dataclass

import numpy as np
import pytest

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.matching.face_colours import face_colours, has_colours

VERTICES = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)


@dataclass(frozen=True)
class Picture:
    image: np.ndarray

    def pixels(self):
        return self.image


def test_texels_are_looked_up_where_the_uv_says_by_material():
    upper = np.zeros((8, 8, 3), np.uint8)
    upper[:4] = [255, 0, 51]  # top row first: v above a half
    blue = np.full((4, 4, 3), [0, 0, 255], np.uint8)
    uv = np.array([[0.1, 0.6], [0.9, 0.6], [0.9, 0.9], [1.2, 1.3], [1.4, 1.1], [1.3, 1.2]])
    mesh = TexturedMesh(
        VERTICES, FACES, uv, np.array([[0, 1, 2], [3, 4, 5]], np.int32), None, (Picture(upper), Picture(blue)),
        np.array([0, 1], np.int32),
    )  # fmt: skip
    np.testing.assert_allclose(face_colours(mesh), [[1, 0, 0.2], [0, 0, 1]])
    # Outside 0..1 images repeat: v = 1.2 is 0.2, in the lower half.
    one = TexturedMesh(VERTICES, FACES, uv, np.array([[0, 1, 2], [3, 4, 5]], np.int32), None, (Picture(upper),))
    np.testing.assert_allclose(face_colours(one), [[1, 0, 0.2], [0, 0, 0]])
    assert has_colours(mesh)


def test_vertex_colours_are_averaged():
    colours = np.array([[0, 0, 0], [255, 0, 0], [255, 255, 0], [0, 0, 255]], np.uint8)
    mesh = TexturedMesh(VERTICES, FACES, colors=colours)
    np.testing.assert_allclose(face_colours(mesh), [[2 / 3, 1 / 3, 0], [1 / 3, 1 / 3, 1 / 3]], rtol=1e-6)


def test_a_mesh_without_colours_is_refused():
    mesh = TexturedMesh(VERTICES, FACES)
    assert not has_colours(mesh)
    with pytest.raises(ValueError, match="mesh: expected textures or vertex colours"):
        face_colours(mesh)
