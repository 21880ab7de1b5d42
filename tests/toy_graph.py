"""Random links and independent walks over the uncontracted graph, for tests that compare by brute force."""

import numpy as np
from toy_capture import ToyCapture, toy_capture

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link


def random_links(seed: int, frames: int, pairs: int, k: int = 3, one_way: int = 0) -> list[Link]:
    """Both directions of ``pairs`` random window pairs in one run, then ``one_way`` single directions."""
    random = np.random.default_rng(seed)
    links: dict[tuple[int, int], Link] = {}
    while len(links) < 2 * pairs + one_way:
        source, target = (int(f) for f in random.integers(k, frames - k, 2))
        ways = [(source, target), (target, source)][: 2 if len(links) < 2 * pairs else 1]
        if abs(source - target) > 2 * k and not any(way in links for way in ways):
            motion = PlanarRigid(*random.normal(size=3))
            for way in ways:
                alignment = motion if way == (source, target) else motion.inverse()
                links[way] = Link(*way, k, alignment, float(random.random()))
    return list(links.values())


def random_case(seed: int, frames: int = 120, pairs: int = 5, k: int = 3) -> tuple[ToyCapture, list[Link]]:
    return toy_capture(frames), random_links(seed, frames, pairs, k)


def frame_successors(runs: list[range], links: list[Link]) -> dict[object, list[object]]:
    """Straight from the definition: captured frames are ints, steps are (source, target, step)."""
    after: dict[object, list[object]] = {}
    for run in runs:
        for frame in run:
            after[frame] = [frame + 1] if frame + 1 in run else []
    for link in links:
        steps = [(link.source, link.target, step) for step in range(-link.k + 1, link.k)]
        after[link.source - link.k].append(steps[0])
        for a, b in zip(steps, [*steps[1:], link.target + link.k], strict=True):
            after[a] = [b]
    return after
