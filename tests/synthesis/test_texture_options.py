import dataclasses
import json

import pytest

from unstructured_mg.synthesis.texture_options import TextureOptions


def test_options_survive_json():
    options = TextureOptions(method="crossfade", texture_size=512)
    assert TextureOptions(**json.loads(json.dumps(dataclasses.asdict(options)))) == options


@pytest.mark.parametrize(
    "wrong",
    [
        {"method": "warp"},
        {"levels": 0},
        {"quality": 101},
        {"texture_size": -1},
        {"levels": 7.0},
        {"edge_length": 0.0},
        {"normal_agreement": 1.0},
        {"tolerance": float("nan")},
    ],
)
def test_values_out_of_range_are_refused_by_name(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        TextureOptions(**wrong)
