import random

import pytest

from unstructured_mg.pipeline.selection import GreedySelection


def is_near(item, others):
    return any(abs(item[0] - other[0]) < 5 and abs(item[1] - other[1]) < 5 for other in others)


def reference(items, good, retries, limit):
    accepted, refused = [], []
    for item in items:
        if limit is not None and len(accepted) >= limit:
            break
        if is_near(item, accepted) or sum(is_near(item, [other]) for other in refused) >= retries:
            continue
        (accepted if item in good else refused).append(item)
    return accepted, refused


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("workers", [1, 2, 7])
def test_any_number_of_workers_chooses_like_one(seed, workers):
    rng = random.Random(seed)
    items = sorted({(rng.randrange(30), rng.randrange(30)) for _ in range(120)})
    rng.shuffle(items)
    good = {item for item in items if rng.random() < 0.4}
    retries, limit = rng.choice([1, 3]), rng.choice([None, 4])

    selection = GreedySelection(items, is_near, retries, limit)
    running = []
    while not selection.finished:
        while len(running) < workers and (index := selection.next()) is not None:
            running.append(index)
        done = running.pop(rng.randrange(len(running)))
        selection.report(done, items[done] in good)
    assert (selection.accepted, selection.refused) == reference(items, good, retries, limit)
