import json
from dataclasses import asdict

import pytest

from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.texture_options import TextureOptions


def test_they_survive_json():
    options = SynthesisOptions(blend="poisson", foot_slide=0.1, texturing=TextureOptions(levels=3))
    found = json.loads(json.dumps(asdict(options)))
    assert SynthesisOptions(**found | {"texturing": TextureOptions(**found["texturing"])}) == options


@pytest.mark.parametrize(
    "wrong",
    [{"blend": "magic"}, {"weights": "quintic"}, {"surface_jump": -1.0}, {"volume_drift": float("nan")}],
)
def test_wrong_values_are_named(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        SynthesisOptions(**wrong)
