from unstructured_mg.playback.quality import QualityRow, quality_rows


def test_measures_limits_and_verdicts_come_out_in_order():
    card = {
        "surface_jump_mm": {"value": 1.25, "limit": 4.0, "holds": True},
        "colour_jump": {"value": 2.5, "limit": 2.0, "holds": False},
        "inverted_tets": 0,
        "seams": {"start": 0.5, "end": None},
        "method": "two_sided",
    }
    assert quality_rows(card) == [
        QualityRow("surface jump mm", "1.25", "4", "good"),
        QualityRow("colour jump", "2.5", "2", "poor"),
        QualityRow("inverted tets", "0"),
        QualityRow("seams: start", "0.5"),
        QualityRow("seams: end", "none"),
        QualityRow("method", "two_sided"),
    ]
    assert quality_rows({}) == []
