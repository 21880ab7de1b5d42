import numpy as np

from unstructured_mg.synthesis.contact import planted


def test_what_stands_low_and_still_in_both_windows_is_planted():
    still = np.zeros((3, 5, 3))
    first, second = still.copy(), still.copy()
    first[:, 1, 2] = 0.1  # high in one window
    second[1, 2, 0] = 0.01  # moves in the other
    second[:, 3, 2] = [0.0, 0.0, 0.1]  # leaves the floor after the first step
    first[:, 4, 2] = [0.0, 0.01, 0.02]  # rises, but not by much
    np.testing.assert_array_equal(planted(first, second, 0), [True, False, False, True, True])
    np.testing.assert_array_equal(planted(first, second, 1), [True, False, False, False, True])
