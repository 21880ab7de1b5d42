import dataclasses
import json

import numpy as np
import pytest

from unstructured_mg.errors import UserError
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.files import read_candidates, read_matching, write_matching
from unstructured_mg.matching.match import Matching


def test_what_is_written_is_read_back_exactly(tmp_path):
    rng = np.random.default_rng(0)
    scores, yaw = rng.random((2, 5, 5)).astype(np.float32)
    scores[0] = np.nan
    candidates = (Candidate(1, 3, 0.1 / 3, -1.2345678901234, 2), Candidate(1, 4, 0.2, 3.0, 5))
    candidates += (Candidate(1, 3, 0.1, 0.5, 1, ((0, 1, 2), (3, 3, 4))),)
    k = rng.integers(1, 20, (5, 5)).astype(np.int16)
    matching = Matching(
        Dissimilarity(scores, yaw, k, 1.75, "rad", 0.125), candidates, candidates[:1], candidates[1:], 0.04375
    )
    write_matching(matching, tmp_path / "matching")
    read = read_matching(tmp_path / "matching")
    np.testing.assert_array_equal(read.dissimilarity.scores, scores)
    np.testing.assert_array_equal(read.dissimilarity.yaw, yaw)
    without = {"dissimilarity": None}
    assert dataclasses.replace(read, **without) == dataclasses.replace(matching, **without)
    np.testing.assert_array_equal(read.dissimilarity.k, k)
    d = read.dissimilarity
    assert (d.size, d.unit, d.rank_error) == (1.75, "rad", 0.125)


def test_a_warp_that_is_none_is_refused(tmp_path):
    path = tmp_path / "candidates.json"
    for warp in ([[0, 1, 2], [3, 4, 4]], [[0, 1, 3], [3, 3, 4]], [[0, 1], [3, 3]], [[0, 1, 2], [3, 3, 9]]):
        path.write_text(json.dumps([{"source": 1, "target": 3, "score": 0.1, "yaw": 0.5, "k": 1, "warp": warp}]))
        with pytest.raises(UserError, match=r"candidates\.json"):
            read_candidates(path, 5)
    path.write_text(json.dumps([{"source": 1, "target": 3, "score": 0.1, "yaw": 0.5, "k": 1, "warp": None}]))
    assert read_candidates(path, 5) == (Candidate(1, 3, 0.1, 0.5, 1),)
