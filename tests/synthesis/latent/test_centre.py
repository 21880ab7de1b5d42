import numpy as np
from toy_pair import bend, club

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.synthesis.latent.centre import centre_all, centre_on


def test_places_and_turns_are_taken_out_and_put_back():
    shape = bend(club().surface, 0.8)
    shape -= shape.mean(0)
    moved = PlanarRigid(2.1, 3.0, -4.0).apply(shape) + [0, 0, 0.7]
    centred = centre_on(moved, shape)
    np.testing.assert_allclose(centred.shape, shape, atol=1e-12)
    np.testing.assert_allclose(centred.put_back(centred.shape), moved, atol=1e-12)


def test_frames_of_one_posture_all_become_one_shape():
    shape = bend(club().surface, 0.8)
    frames = np.stack([PlanarRigid(0.5 * i, i, -i).apply(shape) for i in range(12)])
    shapes, mean = centre_all(frames)
    np.testing.assert_allclose(shapes, np.broadcast_to(shapes[0], shapes.shape), atol=1e-9)
    np.testing.assert_allclose(mean, shapes[0], atol=1e-9)
    np.testing.assert_allclose(shapes.mean(1), 0, atol=1e-12)
