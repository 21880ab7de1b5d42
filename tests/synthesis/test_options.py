import json
from dataclasses import asdict

import pytest

from unstructured_mg.synthesis.options import SynthesisOptions


def test_they_survive_json():
    options = SynthesisOptions(blend="poisson", foot_slide=0.1)
    assert SynthesisOptions(**json.loads(json.dumps(asdict(options)))) == options


@pytest.mark.parametrize(
    "wrong",
    [{"blend": "magic"}, {"weights": "quintic"}, {"surface_jump": -1.0}, {"volume_drift": float("nan")}],
)
def test_wrong_values_are_named(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        SynthesisOptions(**wrong)
