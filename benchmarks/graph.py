"""Transition probabilities against the paper's pattern search (P section 7.1), on random motion graphs.

Both minimise the same energy at the same floor, from the same start (the minimum of the paper's convex proxy), with the
same stationary solver; the search may evaluate the energy 10,000 times, as in the paper. Graphs are about as large as
the paper's largest (Slick Magic): 2283 frames, 36 window pairs, k = 10.

    python benchmarks/graph.py [--quick] [--json FILE]
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

from unstructured_mg.capture.capture import Capture, FrameFile
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.probabilities import Traffic, objective, optimise_probabilities, proxy_minimum

FRAMES, PAIRS, K = 2283, 36, 10
EVALUATIONS = 10_000


def random_traffic(seed: int) -> Traffic:
    """The contracted graph of random window pairs, both directions each."""
    random = np.random.default_rng(seed)
    links: dict[tuple[int, int], Link] = {}
    while len(links) < 2 * PAIRS:
        source, target = (int(frame) for frame in random.integers(K, FRAMES - K, 2))
        if abs(source - target) > 6 * K:
            for way in ((source, target), (target, source)):
                links[way] = Link(*way, K, PlanarRigid(), 0.0)
    frames = tuple(FrameFile("", number, Path()) for number in range(FRAMES))
    graph = build_graph(Capture(Path(), frames, 30.0, 1.0, "z", 0.0), list(links.values()))
    return Traffic.of_edges(len(graph.nodes), [(e.source, e.target, len(e.inner_frames())) for e in graph.edges])


def energy(traffic: Traffic, probabilities: np.ndarray, alpha: float) -> float:
    """The energy without its gradient, which the search has no use for."""
    node, edge = traffic.visits(probabilities)
    uneven = traffic.frames * (node @ node + traffic.inner @ edge**2) - 1
    choice = len(probabilities) / traffic.chain.nodes**2 * (probabilities @ probabilities)
    return float(alpha * uneven + (1 - alpha) * choice)


def pattern_search(
    traffic: Traffic, start: np.ndarray, floor: np.ndarray, alpha: float, evaluations: int
) -> tuple[np.ndarray, float, int]:
    """Generalised pattern search with MATLAB's rules: first success is taken, the mesh doubles, or halves after a poll.

    Directions move probability between a node's last out-edge and each of its others: a positive basis of all that
    keeps the sums. Moves are shortened to stop at the floor. Returns the end, its energy and the evaluations used.
    """
    source = traffic.source
    last = np.searchsorted(source, source, side="right") - 1
    moves = [pair for e in range(len(source)) if e != last[e] for pair in ((e, last[e]), (last[e], e))]
    point, mesh, used, first = start.copy(), 1.0, 1, 0
    value = energy(traffic, point, alpha)
    while mesh > 1e-6:
        improved = False
        for offset in range(len(moves)):
            gains, loses = moves[(first + offset) % len(moves)]
            amount = min(mesh, point[loses] - floor[loses])
            if amount <= 0:
                continue
            if used >= evaluations:
                return point, value, used
            trial = point.copy()
            trial[gains] += amount
            trial[loses] -= amount
            tried = energy(traffic, trial, alpha)
            used += 1
            if tried < value:
                point, value, improved, first = trial, tried, True, (first + offset) % len(moves)
                break
        mesh = min(2 * mesh, 1.0) if improved else mesh / 2
    return point, value, used


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="3 graphs in place of 20")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    arguments = parser.parse_args()
    options = GraphOptions()
    rows = []
    print("graph  nodes  edges   even     ours     search   polished  ours s  search s  evaluations")
    for seed in range(3 if arguments.quick else 20):
        traffic = random_traffic(seed)
        floor = options.least_share / traffic.ways[traffic.source]
        began = time.perf_counter()
        ours = optimise_probabilities(traffic, options)
        our_time = time.perf_counter() - began
        began = time.perf_counter()
        start = proxy_minimum(traffic, options)
        found, search, used = pattern_search(traffic, start, floor, options.alpha, EVALUATIONS)
        search_time = time.perf_counter() - began
        reached = objective(traffic, ours, options.alpha)[0]
        polished = pattern_search(traffic, ours, floor, options.alpha, 2000)[1]
        even = energy(traffic, 1 / traffic.ways[traffic.source], options.alpha)
        rows.append((reached - search, reached - polished, search_time / our_time, our_time))
        print(
            f"{seed:5d} {traffic.chain.nodes:6d} {len(ours):6d}  {even:.6f} {reached:.6f} {search:.6f} {polished:.6f}"
            f"  {our_time:6.3f}  {search_time:8.2f}  {used:6d}"
        )
    above, gain, ratio, seconds = (np.array(column) for column in zip(*rows, strict=True))
    figures = [
        figure("energy above the pattern search's, largest", above.max(), "", 0.0, above.max() <= 1e-9),
        figure("energy that a search from our end still gains, largest", gain.max(), "", 1e-8, gain.max() <= 1e-8),
        figure("times faster than the pattern search, smallest", ratio.min(), "x", 100.0, ratio.min() >= 100),
        figure("seconds a graph, largest", seconds.max(), "s", None, None),
    ]
    for entry in figures:
        print(
            f"{entry['name']}: {entry['value']:.3g} {entry['unit']} (reach {entry['reach']}, holds: {entry['holds']})"
        )
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n")


def figure(name: str, value: float, unit: str, reach: float | None, holds: bool | None) -> dict[str, object]:
    return {
        "name": name,
        "value": float(value),
        "unit": unit,
        "reach": reach,
        "holds": None if holds is None else bool(holds),
    }


if __name__ == "__main__":
    main()
