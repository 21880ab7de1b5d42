import json

import numpy as np
import pytest
from toy_capture import toy_capture

from unstructured_mg.errors import UserError
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.match import Matching
from unstructured_mg.pipeline.choices import NO_CHOICES, Choices, chosen_candidates, read_choices

CAPTURE = toy_capture(60)  # frames 1 to 60, at indices 0 to 59
K = 3


def matching():
    scores = np.arange(3600, dtype=np.float32).reshape(60, 60)
    scores[:K] = scores[-K:] = scores[:, :K] = scores[:, -K:] = np.nan
    k = np.where(np.isnan(scores), 0, K).astype(np.int16)
    candidates = tuple(Candidate(s, t, float(scores[s, t]), 0.5, K) for s, t in ((5, 20), (6, 30), (7, 40)))
    return Matching(Dissimilarity(scores, scores / 1000, k, 1.7, "m"), candidates, candidates, (), 0.1)


def write(path, **content):
    path.write_text(json.dumps(content))
    return path


def test_pins_come_first_in_their_order_and_with_the_matrix_values(tmp_path):
    path = write(tmp_path / "pairs.json", pins=[["41", "8"], [11, 51]], vetoes=[["07", "31"]])
    choices = read_choices(path, CAPTURE, None)
    assert choices == Choices(pins=((7, 40), (10, 50)), vetoes=((6, 30),))
    found = matching()
    chosen = chosen_candidates(choices, found, CAPTURE, path)
    assert chosen == (
        Candidate(7, 40, 460.0, float(np.float32(0.46)), K),
        Candidate(10, 50, 650.0, float(np.float32(0.65)), K),
        *found.candidates[:2],
    )
    assert read_choices(tmp_path / "none.json", CAPTURE, None) == NO_CHOICES
    assert chosen_candidates(NO_CHOICES, found, CAPTURE, path) == found.candidates


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not readable as JSON"),
        ("[]", "expected an object"),
        ('{"pin": []}', "expected an object"),
        ('{"pins": {"1": "2"}}', '"pins" is not a list'),
        ('{"vetoes": [["1", "2"], ["3"]]}', 'number 2 of "vetoes" is not a pair'),
        ('{"vetoes": [["1", 2.5]]}', 'number 1 of "vetoes" is not a pair'),
        ('{"pins": [["1", "99"]]}', 'number 1 of "pins": .*no usable frame "99"'),
        ('{"pins": [["8", "41"]], "vetoes": [["41", "8"]]}', "8 and 41 is both pinned and vetoed"),
        ('{"pins": [["8", "41"], ["9", "41"]]}', "2 pairs are pinned, and at most 1"),
    ],
)
def test_a_file_that_cannot_be_meant_is_named_with_its_place(tmp_path, text, words):
    path = tmp_path / "pairs.json"
    path.write_text(text)
    with pytest.raises(UserError, match=words) as caught:
        read_choices(path, CAPTURE, 1)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(("pin", "words"), [((1, 40), "do not both have a whole window"), ((10, 16), "share frames")])
def test_a_pin_that_no_transition_can_join_is_refused(tmp_path, pin, words):
    with pytest.raises(UserError, match=words):
        chosen_candidates(Choices(pins=(pin,)), matching(), CAPTURE, tmp_path / "pairs.json")
