import math

import pytest

from unstructured_mg.playback.svg import apart, label, length, number, percent, round_steps


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (0.0, "0"), (1234567, "1234567"), (0.123456, "0.1235"), (-2.5, "−2.5"), (1e-7, "1e-07"), (True, "yes")],
)
def test_numbers_are_short(value, text):
    assert number(value) == text


def test_numbers_that_are_not_finite_are_named():
    assert [number(value) for value in (math.nan, math.inf, -math.inf)] == ["none", "∞", "−∞"]


@pytest.mark.parametrize(
    ("metres", "text"),
    [
        (0.0, "0 mm"),
        (0.00012, "0.1 mm"),
        (-0.0123, "−12.3 mm"),
        (0.05, "50 mm"),
        (0.3161, "316 mm"),
        (1.234567, "1.235 m"),
    ],
)
def test_lengths_are_in_millimetres_below_a_metre(metres, text):
    assert length(metres) == text


def test_dissimilarities_are_in_the_unit_of_their_descriptor():
    assert apart(0.0375, "m") == "37.5 mm"
    assert apart(math.pi / 8, "rad") == "22.5°"
    assert apart(0.012345, "") == "0.0123"


def test_shares_are_in_percent():
    assert [percent(share) for share in (0.0, 0.00123456, 0.5, -0.02)] == ["0 %", "0.123 %", "50 %", "−2 %"]


@pytest.mark.parametrize("highest", [0.003, 0.9, 1.0, 1.08, 7.0, 149.0, 2283.0])
@pytest.mark.parametrize("about", [4, 8])
def test_round_steps_start_at_zero_and_do_not_pass_the_highest(highest, about):
    steps = round_steps(highest, about)
    step = steps[1]
    assert steps[0] == 0 and steps[-1] <= highest * (1 + 1e-9) < steps[-1] + step
    assert about / 2.6 <= len(steps) - 1 <= about
    mantissa = step / 10 ** math.floor(math.log10(step) + 1e-9)
    assert min(abs(mantissa - round_one) for round_one in (1, 2, 5)) < 1e-9


def test_labels_escape():
    assert ">a &lt;b&gt; &amp;<" in label(1, 2, "a <b> &")
