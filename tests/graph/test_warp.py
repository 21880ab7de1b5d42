from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from unstructured_mg.graph.warp import best_warp, warp_costs

RUNS = [range(0, 9), range(9, 16)]


def distances(seed, n=16):
    values = np.random.default_rng(seed).random((n, n)).astype(np.float32)
    values[3, 11] = np.nan
    return values


def every_warp(leaves, arrives, shortest, longest, odd):
    """All warps from frame to frame, straight from B's rules."""
    source, target = (next(run for run in RUNS if frame in run) for frame in (leaves, arrives))
    found = []

    def grow(path, steps):
        (a, c), (first, begin) = path[-1], path[0]
        if (
            c == arrives
            and shortest <= a - first + 1 <= longest
            and shortest <= c - begin + 1 <= longest
            and (len(path) % 2 or not odd)
        ):
            found.append(list(path))
        for step in ((1, 1), (1, 0), (0, 1)):
            after = (a + step[0], c + step[1])
            if after[0] not in source or after[1] not in target or after[1] > arrives or after[0] - first + 1 > longest:
                continue
            if step != (1, 1) and steps[-3:] == [step] * 3:
                continue
            grow([*path, after], [*steps, step])

    for begin in target:
        if begin <= arrives and arrives - begin + 1 <= longest:
            grow([(leaves, begin)], [])
    return found


@pytest.mark.parametrize(("shortest", "longest", "odd"), [(3, 5, True), (2, 4, False), (1, 5, True), (5, 5, False)])
def test_costs_are_the_least_of_all_warps(shortest, longest, odd):
    values = distances(longest)
    costs = warp_costs(values, RUNS, 0.25, shortest, longest, odd=odd)
    for leaves in (0, 2, 4, 8, 9, 13):
        for arrives in (1, 4, 8, 9, 11, 15):
            warps = every_warp(leaves, arrives, shortest, longest, odd)
            paid = [sum(float(values[pair]) + 0.25 for pair in warp) for warp in warps]
            least = min((p for p in paid if np.isfinite(p)), default=np.inf)
            assert costs[leaves, arrives] == pytest.approx(least, rel=1e-5)
            found = best_warp(values, RUNS, leaves, arrives, 0.25, shortest, longest, odd=odd)
            if np.isinf(least):
                assert found is None
                continue
            assert found.cost == costs[leaves, arrives]
            path = list(zip(found.source.tolist(), found.target.tolist(), strict=True))
            assert path in warps
            assert sum(float(values[pair]) + 0.25 for pair in path) == pytest.approx(least, rel=1e-5)


def test_both_terms_together_are_never_dearer_than_one_after_the_other():
    """B takes the warp of least deformation and pays for its duration afterwards."""
    values = distances(0)
    jointly = warp_costs(values, RUNS, 0.25, 3, 5, odd=False)
    deformation = warp_costs(values, RUNS, 0.0, 3, 5, odd=False)
    cheaper = 0
    for leaves in range(5):
        for arrives in range(11, 16):
            warp = best_warp(values, RUNS, leaves, arrives, 0.0, 3, 5, odd=False)
            theirs = deformation[leaves, arrives] + 0.25 * len(warp.source)
            assert jointly[leaves, arrives] <= theirs + 1e-5
            cheaper += jointly[leaves, arrives] < theirs - 1e-3
    assert cheaper > 0


def test_blocks_and_workers_change_nothing(monkeypatch):
    values = np.random.default_rng(1).random((90, 90)).astype(np.float32)
    runs = [range(0, 50), range(50, 90)]
    alone = warp_costs(values, runs, 0.1, 4, 9, odd=True)
    with ThreadPoolExecutor(2) as executor:
        np.testing.assert_array_equal(warp_costs(values, runs, 0.1, 4, 9, odd=True, executor=executor), alone)
    monkeypatch.setattr("unstructured_mg.graph.warp.BLOCK", 7)
    np.testing.assert_array_equal(warp_costs(values, runs, 0.1, 4, 9, odd=True), alone)


def test_of_two_like_motions_at_different_speeds_the_slower_is_held():
    slow, fast = np.arange(0, 10, 0.5), np.arange(0, 10, 1.0)
    pose = np.concatenate([slow, fast])
    runs = [range(0, 20), range(20, 30)]
    values = np.abs(pose[:, None] - pose).astype(np.float32)
    warp = best_warp(values, runs, 2, 27, 1e-3, 5, 20, odd=True)
    assert warp.source[0] == 2 and warp.target[-1] == 27
    # Half the source's frames have a target's frame of their own pose; the others lie half a frame off.
    assert np.abs(pose[warp.source] - pose[warp.target]).mean() < 0.3


def test_nothing_to_warp_is_nothing():
    assert warp_costs(np.zeros((0, 0)), [], 0.1, 3, 5, odd=True).shape == (0, 0)
