import numpy as np
from tracking.walkers import swaying

from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.tracking.cage import build_cage, read_cage, write_cage
from unstructured_mg.tracking.files import read_pair, write_pair
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.track import track_pair


def test_pair_and_cage_come_back_as_they_were(tmp_path):
    capture, options = swaying(12), TrackingOptions(cage_vertices=300)
    cage = build_cage(capture.read(2), options)
    write_cage(cage, tmp_path)
    again = read_cage(tmp_path)
    assert again.method == cage.method == "lattice"
    for name in ("vertices", "tets", "tet_of_vertex", "weights", "residual"):
        np.testing.assert_array_equal(getattr(again, name), getattr(cage, name))
    pair = track_pair(capture, Candidate(2, 8, 0.5, -0.9, 1), 2, again, options)
    write_pair(pair, capture, tmp_path)
    stored = read_pair(tmp_path)
    for name, value in vars(pair).items():
        if name == "measures":
            assert sorted(stored.measures) == sorted(value)
            for key in value:
                np.testing.assert_array_equal(stored.measures[key], value[key])
        elif isinstance(value, np.ndarray):
            np.testing.assert_array_equal(getattr(stored, name), value)
            assert getattr(stored, name).dtype == value.dtype
        else:
            assert getattr(stored, name) == value
