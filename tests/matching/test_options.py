import pytest

from unstructured_mg.matching.options import MatchingOptions


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("descriptor", "none"),
        ("resolution", 20),
        ("resolution", 8),
        ("rank", 0),
        ("windows", "long"),
        ("largest_k", 12),
        ("colour_m", -0.1),
        ("k", 0),
        ("velocity_seconds", -1.0),
        ("minimum_gap_seconds", float("nan")),
        ("separation_seconds", 0.0),
        ("threshold", float("inf")),
        ("alternatives", -1),
        ("nearest", -1),
    ],
)
def test_bad_values_are_named(name, value):
    with pytest.raises(ValueError, match=f"{name}: expected .* got "):
        MatchingOptions(**{name: value})
