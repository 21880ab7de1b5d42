import numpy as np

from unstructured_mg.matching.velocity import root_velocities
from unstructured_mg.matching.window import spline_weights


def test_steady_travel_gives_its_velocity_in_metres_a_second():
    roots = np.outer(np.arange(30), [0.02, -0.01])
    velocities = root_velocities(roots, spline_weights(5), fps=25.0)
    np.testing.assert_allclose(velocities[5:25], 0.5 - 0.25j, rtol=1e-12)
    assert np.isnan(velocities[:5]).all() and np.isnan(velocities[25:]).all()


def test_slope_is_that_of_the_weighted_least_squares_line():
    roots = np.random.default_rng(0).normal(size=(11, 2))
    steps = np.arange(-5.0, 6.0)
    slope = np.polyfit(steps, roots, 1, w=np.sqrt(spline_weights(5)))[0]
    found = root_velocities(roots, spline_weights(5), fps=1.0)[5]
    np.testing.assert_allclose([found.real, found.imag], slope, rtol=1e-10)


def test_too_short_a_capture_has_none():
    assert np.isnan(root_velocities(np.zeros((4, 2)), spline_weights(2), 30.0)).all()
