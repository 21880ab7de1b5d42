import pytest

from unstructured_mg.tracking.options import TrackingOptions


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("cage", "box"),
        ("cage_vertices", 49),
        ("tetwild_seconds", 0.0),
        ("debris_share", 1.0),
        ("debris_share", -0.1),
        ("hausdorff_m", 0.0),
        ("hausdorff_m", float("nan")),
        ("rigidity", -1.0),
        ("detail_normals", 0.0),
        ("detail_offsets", 0.0),
        ("detail_levels", 0),
    ],
)
def test_values_out_of_range_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}: expected"):
        TrackingOptions(**{name: value})
