import pytest

from unstructured_mg.graph.options import GraphOptions


@pytest.mark.parametrize(
    ("name", "value"), [("alpha", -0.1), ("alpha", 1.5), ("least_share", 2), ("least_share", float("nan")),
                        ("cost_weight", -1), ("cost_weight", float("inf"))],
)  # fmt: skip
def test_values_out_of_range_are_named(name, value):
    with pytest.raises(ValueError, match=f"{name}: expected"):
        GraphOptions(**{name: value})
