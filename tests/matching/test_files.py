import dataclasses

import numpy as np

from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.files import read_matching, write_matching
from unstructured_mg.matching.match import Matching


def test_what_is_written_is_read_back_exactly(tmp_path):
    rng = np.random.default_rng(0)
    scores, yaw = rng.random((2, 5, 5)).astype(np.float32)
    scores[0] = np.nan
    candidates = (Candidate(1, 3, 0.1 / 3, -1.2345678901234, 2), Candidate(1, 4, 0.2, 3.0, 5))
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
