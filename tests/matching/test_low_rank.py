import numpy as np
import pytest
from array_capture import array_capture, figure

from unstructured_mg.matching.dissimilarity import compute_dissimilarity
from unstructured_mg.matching.low_rank import largest_error, learn_basis, project
from unstructured_mg.matching.options import MatchingOptions


def packed(frames, dimensions, seed=0):
    """Rough X and E of so many dimensions: packed descriptions of 6 frequencies and 40 cells."""
    rng = np.random.default_rng(seed)

    def complex_normal(*shape):
        return rng.normal(size=shape) + 1j * rng.normal(size=shape)

    amounts, directions, rough = (
        complex_normal(*shape) for shape in ((frames, 6, dimensions), (6, dimensions, 40), (frames, 6, 40))
    )
    amounts[:, 0], directions[0], rough[:, 0] = amounts[:, 0].real, directions[0].real, rough[:, 0].real
    values = np.concatenate([rough, np.einsum("nfd,fdc->nfc", amounts, directions)], axis=1)
    return values.astype(np.complex64)


def test_what_has_the_rank_is_exact():
    values = packed(30, 4)
    basis = learn_basis(values[:10], 4)
    assert basis.shape == (6, 40, 4)
    reduced = np.stack([project(each, basis)[0] for each in values])
    whole = np.einsum("sfc,tfc->stf", values[:, :6], values[:, 6:])
    np.testing.assert_allclose(np.einsum("sfc,tfc->stf", reduced[:, :6], reduced[:, 6:]), whole, atol=1e-2, rtol=1e-3)
    assert largest_error(values[10:], basis) < 1e-3 * np.abs(whole).max() ** 0.5
    own = whole[3, 3].real
    assert project(values[3], basis)[1] == pytest.approx((own[0] + 2 * own[1:].sum()) / 12, rel=1e-3)
    assert largest_error(values[10:], learn_basis(values[:10], 2)) > 0.1


def test_scores_in_a_basis_are_off_by_about_what_is_stated(tmp_path):
    capture = array_capture([figure(0.25 * i, 0.1 * i, seed=i) for i in range(40)])
    whole = compute_dissimilarity(capture, MatchingOptions(resolution=16, k=2), scratch=tmp_path)
    assert whole.rank_error is None
    errors = []
    for rank in (3, 12):
        options = MatchingOptions(resolution=16, k=2, rank=rank)
        found = compute_dissimilarity(capture, options, scratch=tmp_path)
        assert found.rank_error is not None
        seen = np.nanmax(np.abs(found.scores - whole.scores))
        assert 0 < seen < 1.5 * found.rank_error
        errors.append(found.rank_error)
        assert list(tmp_path.iterdir()) == []
    assert errors[1] < errors[0] / 2
