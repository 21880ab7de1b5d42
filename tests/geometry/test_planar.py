import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid

A, B = PlanarRigid(0.3, 1.0, -2.0), PlanarRigid(-1.2, 0.5, 4.0)
POINTS = np.random.default_rng(0).normal(size=(10, 3))


def test_composition_and_inverse_agree_with_matrices():
    np.testing.assert_allclose(A.after(B).matrix(), A.matrix() @ B.matrix())
    np.testing.assert_allclose(A.after(A.inverse()).matrix(), np.eye(4), atol=1e-15)
    np.testing.assert_allclose(A.after(B).apply(POINTS), A.apply(B.apply(POINTS)))
    np.testing.assert_allclose(PlanarRigid.from_matrix(A.matrix()).matrix(), A.matrix())
