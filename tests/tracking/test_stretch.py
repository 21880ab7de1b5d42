import numpy as np
from scipy.spatial.transform import Rotation
from tracking.bodies import tube

from unstructured_mg.tracking.stretch import Stretch


def test_stretch_is_the_singular_values_of_the_map():
    vertices, faces = tube(0.2, 1.0, 40, 30)
    rng = np.random.default_rng(2)
    moved = vertices + rng.normal(scale=2e-3, size=vertices.shape)
    found = Stretch(vertices, faces).per_face(moved)

    def flat(v):
        """Edge vectors (m, 2, 2) of each triangle in a frame of its own."""
        u, w = v[faces[:, 1]] - v[faces[:, 0]], v[faces[:, 2]] - v[faces[:, 0]]
        x = u / np.linalg.norm(u, axis=1, keepdims=True)
        y = w - (w * x).sum(1, keepdims=True) * x
        y /= np.linalg.norm(y, axis=1, keepdims=True)
        return np.stack([np.stack([(e * x).sum(1), (e * y).sum(1)], 1) for e in (u, w)], axis=2)

    values = np.linalg.svd(flat(moved) @ np.linalg.inv(flat(vertices)), compute_uv=False)
    np.testing.assert_allclose(found, np.maximum(values[:, 0], 1 / values[:, 1]), rtol=1e-6)


def test_a_turn_stretches_nothing_and_a_scale_everything():
    vertices, faces = tube(0.2, 1.0, 40, 30)
    stretch = Stretch(vertices, faces)
    turned = vertices @ Rotation.from_rotvec([1.0, 2.0, 0.5]).as_matrix().T
    np.testing.assert_allclose(stretch.p95(turned), 1, atol=1e-6)
    np.testing.assert_allclose(stretch.p95(1.5 * turned), 1.5, atol=1e-6)
    np.testing.assert_allclose(stretch.p95(turned / 1.5), 1.5, atol=1e-6)


def test_a_small_part_does_not_count_and_collapse_is_infinite():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.01], [0.1, 0, 0.01], [0, 0.1, 0.01]])
    faces = np.array([[0, 1, 2], [3, 4, 5], [0, 1, 1]], np.int32)
    moved = vertices.copy()
    moved[5] = moved[4]
    stretch = Stretch(vertices, faces)
    np.testing.assert_array_equal(stretch.per_face(moved), [1, np.inf, 1])
    assert stretch.p95(moved) == 1
