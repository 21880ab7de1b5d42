import pytest

from unstructured_mg.capture.sidecar import read_sidecar
from unstructured_mg.errors import UserError


def test_known_keys_are_read_and_others_passed_over(tmp_path):
    assert read_sidecar(tmp_path) == {}
    (tmp_path / "sequence.json").write_text('{"fps": 25, "maxVertexCount": 9}')
    assert read_sidecar(tmp_path) == {"fps": 25.0}
    (tmp_path / "capture.json").write_text('{"unit": "mm", "up": "z", "floor": -3, "fps": null}')
    assert read_sidecar(tmp_path) == {"unit": 0.001, "up": "z", "floor": -3.0}


@pytest.mark.parametrize(
    "text",
    ["", "[1]", "{", '{"fps": 0}', '{"fps": true}', '{"fps": NaN}', '{"unit": "ell"}', '{"unit": -1}', '{"up": "up"}']
    + ['{"up": 2}', '{"floor": "low"}', '{"floor": Infinity}', "[" * 100_000, "\udcff"],
)
def test_what_cannot_be_meant_is_refused_in_one_sentence(tmp_path, text):
    (tmp_path / "capture.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(UserError, match=r"capture\.json: .*; .*\.$"):
        read_sidecar(tmp_path)
