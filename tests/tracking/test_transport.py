import numpy as np
from scipy.optimize import linprog

from unstructured_mg.tracking.transport import Transport


def test_a_sharp_plan_is_the_optimal_assignment():
    rng = np.random.default_rng(0)
    points, goals = rng.random((12, 3)), rng.random((12, 3))
    up = np.tile([0.0, 0.0, 1.0], (12, 1))
    shares = np.full(12, 1 / 12)
    means, mass = Transport(shares, goals, up, shares, 0.1).mean_goals(points, up, 0.03, 20000)
    cost = ((points[:, None] - goals) ** 2).sum(2)
    rows = np.kron(np.eye(12), np.ones(12))
    columns = np.kron(np.ones(12), np.eye(12))
    best = linprog(cost.ravel(), A_eq=np.concatenate([rows, columns]), b_eq=np.full(24, 1 / 12)).x.reshape(12, 12)
    np.testing.assert_allclose(means, goals[best.argmax(1)], atol=0.02)
    np.testing.assert_allclose(mass, shares, rtol=0.02)


def test_two_limbs_are_not_sent_to_one():
    # The second limb's nearest goals are the first's; a plan leaves those to the first.
    line = np.stack([np.zeros(20), np.zeros(20), np.linspace(0, 1, 20)], 1)
    points = np.concatenate([line, line + [0.3, 0, 0]])
    goals = np.concatenate([line + [0.2, 0, 0], line + [0.9, 0, 0]])
    side = np.tile([1.0, 0.0, 0.0], (40, 1))
    shares = np.full(40, 1 / 40)
    means, _ = Transport(shares, goals, side, shares, 0.1).mean_goals(points, side, 0.2, 60)
    assert np.abs(means[:20, 0] - 0.2).max() < 0.05
    assert np.abs(means[20:, 0] - 0.9).max() < 0.05


def test_normals_tell_front_from_back():
    points = np.array([[0.0, 0, 0], [0.1, 0, 0]])
    normals = np.array([[-1.0, 0, 0], [1.0, 0, 0]])
    goals = points + [0.1, 0, 0]
    shares = np.array([0.5, 0.5])
    means, _ = Transport(shares, goals, normals, shares, 0.5).mean_goals(points, normals, 0.1, 50)
    np.testing.assert_allclose(means, goals, atol=1e-6)
