"""Random links and independent walks over the uncontracted graph, for tests that compare by brute force."""

import numpy as np
from toy_capture import ToyCapture, toy_capture

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.floor_track import moved
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import MotionGraph, Segment, build_graph
from unstructured_mg.graph.places import Places


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


def toy_places(capture: ToyCapture, links: list[Link], seed: int = 0) -> Places:
    """A random walk over the floor in every run; steps lie evenly between the frames that their link joins."""
    random = np.random.default_rng(seed)
    captured = np.cumsum(random.normal(scale=0.02, size=(len(capture), 2)) + [0.03, 0], axis=0)
    steps = []
    for link in links:
        arrives = moved(captured[link.arrives], link.alignment)
        share = (np.arange(1, 2 * link.k) / (2 * link.k))[:, None]
        steps.append((1 - share) * captured[link.leaves] + share * arrives)
    return Places(captured, tuple(steps))


def placed_case(seed: int, frames: int = 120, pairs: int = 5, k: int = 3) -> tuple[ToyCapture, MotionGraph]:
    """A random graph that knows its places; what the links join is a stride apart at most."""
    capture, links = random_case(seed, frames, pairs, k)
    captured = toy_places(capture, []).captured
    near = []
    for link in links:
        turn = PlanarRigid(yaw=link.alignment.yaw)
        x, y = captured[link.leaves] + [0.1, 0.05] - moved(captured[link.arrives], turn)
        near.append(Link(link.source, link.target, link.k, PlanarRigid(turn.yaw, float(x), float(y)), link.cost))
    return capture, build_graph(capture, near, places=toy_places(capture, near))


def played_names(graph: MotionGraph, segments: tuple[Segment, ...]) -> list[object]:
    """The frames that segments play: captured ones are ints, steps are (source, target, step)."""
    names: list[object] = []
    for segment in segments:
        link = None if segment.link is None else graph.links[segment.link]
        names += [i if link is None else (link.source, link.target, i) for i in range(segment.first, segment.last + 1)]
    return names


def least_costs(graph: MotionGraph, capture: ToyCapture, start: int, goal: int, frames: int) -> np.ndarray:
    """For every length the least cost, frame by frame over the uncontracted graph."""
    after = frame_successors(capture.runs(), list(graph.links))
    costs = {(link.source, link.target): link.cost for link in graph.links}
    inside = set(graph.frames.tolist())
    now, found = {start: 0.0}, []
    for _ in range(frames + 1):
        found.append(now.get(goal, np.inf))
        then = {}
        for a, cost in now.items():
            for b in after[a]:
                entering = isinstance(b, tuple) and not isinstance(a, tuple)
                if isinstance(b, tuple) or b in inside:
                    paid = cost + (costs[b[:2]] if entering else 0)
                    then[b] = min(then.get(b, np.inf), paid)
        now = then
    return np.array(found)
