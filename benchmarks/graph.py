"""Graphs and paths: every claim of the graph room beside a peer.

Probabilities against the paper's pattern search (P section 7.1): both minimise the same energy at the same floor, from
the same start (the minimum of the paper's convex proxy), with the same stationary solver; the search may evaluate the
energy 10,000 times, as in the paper. Graphs are about as large as the paper's largest (Slick Magic): 2283 frames, 36
window pairs, k = 10.

Exact lengths: dynamic programming against the integer programme on random graphs, which must agree.

Distance and time (H Table 1): 20 distances by 40 durations between two key frames, on a surface motion graph
of the procedural performance, each of its actions a clip. Queries that some walk can meet within H's largest errors (1
m, 25 frames) are counted apart; for the others the programme proves that no walk misses by less.

The essential graph against a motion graph (B Fig. 6): transitions of the same costs, at all local minima of the cost
between any two clips; the costs of the cheapest ways between all pairs of frames, sorted. And its time for 2,600
frames.

    python benchmarks/graph.py [--quick] [--json FILE] [--picture FILE.svg]
"""

import argparse
import json
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from scipy.ndimage import minimum_filter
from scipy.sparse.csgraph import dijkstra

from unstructured_mg.capture.capture import Capture, FrameFile
from unstructured_mg.capture.procedural.motion import choreograph
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.construction import CONSTRUCTIONS
from unstructured_mg.graph.distance_time import solve_distance_time
from unstructured_mg.graph.essential import QUANTUM, complete_costs, essential_graph, way_costs
from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.floor_track import moved
from unstructured_mg.graph.flows import entropy_rate, optimise_flows
from unstructured_mg.graph.link import Link
from unstructured_mg.graph.motion_graph import MotionGraph, build_graph
from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.places import Places
from unstructured_mg.graph.probabilities import Traffic, objective, optimise_probabilities, proxy_minimum
from unstructured_mg.graph.routes import build_routes
from unstructured_mg.matching.dissimilarity import Dissimilarity
from unstructured_mg.matching.match import Matching
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.matching.window import spline_weights

FRAMES, PAIRS, K = 2283, 36, 10
EVALUATIONS = 10_000
# H Table 1: the largest errors, and the worst of its rows.
MOST_METRES, MOST_FRAMES, RMS_METRES, RMS_FRAMES = 1.0, 25, 0.47, 8.78

Figure = dict[str, object]


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


def probabilities(quick: bool) -> list[Figure]:
    """Ours against the pattern search."""
    options = GraphOptions()
    rows = []
    print("graph  nodes  edges   even     ours     search   polished  ours s  search s  evaluations  entropy, of most")
    for seed in range(3 if quick else 20):
        traffic = random_traffic(seed)
        floor = options.least_share / traffic.ways[traffic.source]
        began = time.process_time()
        ours = optimise_probabilities(traffic, options)
        our_time = time.process_time() - began
        began = time.process_time()
        start = proxy_minimum(traffic, options)
        found, search, used = pattern_search(traffic, start, floor, options.alpha, EVALUATIONS)
        search_time = time.process_time() - began
        reached = objective(traffic, ours, options.alpha)[0]
        polished = pattern_search(traffic, ours, floor, options.alpha, 2000)[1]
        even = energy(traffic, 1 / traffic.ways[traffic.source], options.alpha)
        began = time.process_time()
        wildest = optimise_flows(traffic, GraphOptions(alpha=0.0))
        flow_time = time.process_time() - began
        entropy, most = entropy_rate(traffic, ours), entropy_rate(traffic, wildest)
        choices = ours[traffic.ways[traffic.source] > 1]
        rows.append(
            (
                reached - search,
                reached - polished,
                search_time / our_time,
                our_time,
                choices.min(),
                entropy / most,
                flow_time,
            )
        )
        print(
            f"{seed:5d} {traffic.chain.nodes:6d} {len(ours):6d}  {even:.6f} {reached:.6f} {search:.6f} {polished:.6f}"
            f"  {our_time:6.3f}  {search_time:8.2f}  {used:11d}  {entropy:.4f}, {entropy / most:.3f}"
        )
    above, gain, ratio, seconds, least, share, flow_seconds = (np.array(column) for column in zip(*rows, strict=True))
    return [
        figure("energy above the pattern search's, largest", above.max(), "", 0.0, above.max() <= 1e-9),
        figure("energy that a search from our end still gains, largest", gain.max(), "", 1e-8, gain.max() <= 1e-8),
        figure("times faster than the pattern search, smallest", ratio.min(), "x", 100.0, ratio.min() >= 100),
        figure("CPU seconds a graph, largest", seconds.max(), "s", None, None),
        figure("smallest probability where there is a choice", least.min(), "", None, None),
        figure("entropy rate as a share of the most that is possible, smallest", share.min(), "", None, None),
        figure("CPU seconds of the convex programme, largest", flow_seconds.max(), "s", None, None),
    ]


def exact_lengths(quick: bool) -> list[Figure]:
    """Dynamic programming and the integer programme on random graphs."""
    differences, times = [], []
    for seed in range(10 if quick else 100):
        random = np.random.default_rng(seed)
        links: dict[tuple[int, int], Link] = {}
        while len(links) < 12:
            source, target = (int(frame) for frame in random.integers(5, 295, 2))
            if abs(source - target) > 10:
                for way in ((source, target), (target, source)):
                    links[way] = Link(*way, 5, PlanarRigid(), float(random.random()))
        frames = tuple(FrameFile("", number, Path()) for number in range(300))
        capture = Capture(Path(), frames, 30.0, 1.0, "z", 0.0)
        graph = build_graph(capture, list(links.values()))
        start, goal = (int(frame) for frame in random.choice(graph.frames, 2))
        routes = build_routes(graph, capture, start, goal)
        began = time.process_time()
        table = LengthTable(routes)
        length = table.possible(routes.start, int(random.integers(100, 600)))
        assert length is not None
        least = table.upto(length)[length, routes.start]
        middle = time.process_time()
        found = solve_distance_time(routes, None, length, exact_frames=True)
        times.append((middle - began, time.process_time() - middle))
        differences.append(np.inf if found is None else abs(found.objective - least))
    ours, theirs = np.mean(times, axis=0)
    print(f"\n{len(times)} random graphs: {ours:.4f} s by dynamic programming, {theirs:.4f} s by integer programming")
    worst = max(differences)
    return [
        figure("cost by dynamic and by integer programming, largest difference", worst, "", 1e-9, worst <= 1e-9),
        figure("CPU seconds of dynamic programming, mean", ours, "s", None, None),
        figure("CPU seconds of integer programming, mean", theirs, "s", None, None),
    ]


def performance(frames: int) -> tuple[Capture, np.ndarray, np.ndarray, np.ndarray]:
    """The procedural performance, each action a clip: (capture, poses (n, m), yaw (n,), places (n, 2)).

    A pose is the joints about the pelvis, turned to face one way, scaled so that distances are root mean squares.
    """
    motion = choreograph(frames, 0)
    clips = np.empty(frames, object)
    for number, action in enumerate(motion.actions):
        clips[action.first : action.last + 1] = f"{number:02d} {action.name}"
    files = tuple(FrameFile(str(clips[i]), i, Path(f"{i}.obj")) for i in range(frames))
    places = motion.positions[:, 0, :2]
    own = motion.positions - np.concatenate([places, np.zeros((frames, 1))], axis=1)[:, None]
    c, s = np.cos(-motion.yaw)[:, None], np.sin(-motion.yaw)[:, None]
    turned = np.stack([c * own[..., 0] - s * own[..., 1], s * own[..., 0] + c * own[..., 1], own[..., 2]], axis=2)
    poses = turned.reshape(frames, -1) / np.sqrt(turned.shape[1])
    return Capture(Path(), files, 25.0, 1.0, "z", 0.0), poses, motion.yaw, places


def pose_distances(poses: np.ndarray) -> np.ndarray:
    """(n, n) float32."""
    squares = (poses**2).sum(axis=1)
    return np.sqrt(np.maximum(squares[:, None] + squares - 2 * poses @ poses.T, 0)).astype(np.float32)


def surface_graph(k: int = 5) -> tuple[Capture, MotionGraph]:
    """A surface motion graph of the performance: every two actions joined at their two best places, however good."""
    capture, poses, yaw, places = performance(360)
    n = len(capture)
    squares = pose_distances(poses) ** 2
    scores = np.full((n, n), np.nan, np.float32)
    weights, inner = spline_weights(k), slice(k, n - k)
    scores[inner, inner] = np.sqrt(
        sum(w * squares[i : n - 2 * k + i, i : n - 2 * k + i] for i, w in enumerate(weights))
    )
    centres = capture.window_centres(k)
    scores[~(centres[:, None] & centres)] = np.nan
    turn = np.subtract.outer(yaw, yaw).astype(np.float32)
    found = Dissimilarity(scores, turn, np.full((n, n), k, np.int16), 1.8, "m")
    options = MatchingOptions(k=k, minimum_gap_seconds=0.5, alternatives=1)
    matching = Matching(found, (), (), (), np.inf)
    links, steps = [], []
    blend = np.arange(1, 2 * k) / (2 * k)
    blend = (blend * blend * (3 - 2 * blend))[:, None]
    for candidate in CONSTRUCTIONS["surface"].choose(capture, matching, options, GraphOptions(), None):
        for s, t in ((candidate.source, candidate.target), (candidate.target, candidate.source)):
            angle = float(yaw[s] - yaw[t])
            x, y = places[s] - moved(places[t], PlanarRigid(angle))
            motion = PlanarRigid(angle, float(x), float(y))
            links.append(Link(s, t, k, motion, candidate.score))
            own, other = places[s - k + 1 : s + k], moved(places[t - k + 1 : t + k], motion)
            steps.append((1 - blend) * own + blend * other)
    return capture, build_graph(capture, links, places=Places(places, tuple(steps)))


def distance_and_time(quick: bool) -> list[Figure]:
    """H's grid."""
    capture, graph = surface_graph()
    clips = sorted({capture.frames[int(frame)].clip for frame in graph.frames})
    print(f"\nsurface motion graph: {len(clips)} motions, {len(graph.nodes)} nodes, {len(graph.edges)} edges")
    print(
        "key frames          queries  met  smoothness cm  distance m: min rms max  frames: min rms max  CPU s: mean dev"
    )
    ends = [(int(graph.frames[0]), int(graph.frames[-1]))]
    met_rows, times, missed = [], [], 0
    for start, goal in ends:
        routes = build_routes(graph, capture, start, goal)
        rows = []
        for metres in range(1, 21, 5 if quick else 1):
            for seconds in range(1, 41, 5 if quick else 1):
                wanted = int(seconds * capture.fps)
                began = time.process_time()
                found = solve_distance_time(routes, float(metres), wanted)
                times.append(time.process_time() - began)
                assert found is not None
                links = [s.link for a in found.arcs for s in routes.arcs[a].segments if s.link is not None]
                smooth = [100 * graph.links[link].cost for link in links] or [0.0]
                rows.append((abs(found.distance - metres), abs(found.frames - wanted), min(smooth), max(smooth)))
        table = np.array(rows)
        met = table[(table[:, 0] <= MOST_METRES) & (table[:, 1] <= MOST_FRAMES)]
        missed += len(table) - len(met)
        met_rows.append(met)
        d, t = met[:, 0], met[:, 1]
        here = np.array(times[-len(table) :])
        name = f"{capture.frame_id(start)} to {capture.frame_id(goal)}"
        print(
            f"{name:20.20s} {len(table):6d} {len(met):4d}   {table[:, 2].min():5.2f} {table[:, 3].max():5.2f}    "
            f"{d.min():.4f} {np.sqrt((d**2).mean()):.3f} {d.max():.2f}          {t.min():.0f} "
            f"{np.sqrt((t**2).mean()):.2f} {t.max():.0f}           {here.mean():.3f} {here.std():.3f}"
        )
    met = np.concatenate(met_rows)
    rms_metres, rms_frames = np.sqrt((met[:, :2] ** 2).mean(axis=0))
    seconds = float(np.mean(times))
    return [
        figure("queries that a walk can meet", len(met), "", None, None),
        figure("queries with the smallest possible miss, proved", missed, "", None, None),
        figure("distance error, rms", rms_metres, "m", RMS_METRES, rms_metres <= RMS_METRES),
        figure("distance error, largest", met[:, 0].max(), "m", MOST_METRES, met[:, 0].max() <= MOST_METRES),
        figure("time error, rms", rms_frames, "frames", RMS_FRAMES, rms_frames <= RMS_FRAMES),
        figure("time error, largest", met[:, 1].max(), "frames", MOST_FRAMES, met[:, 1].max() <= MOST_FRAMES),
        figure("CPU seconds a query, mean", seconds, "s", 0.1, seconds <= 0.1),
    ]


def local_minima(costs: np.ndarray, runs: list[range]) -> tuple[np.ndarray, np.ndarray]:
    """Where a standard motion graph has its transitions: all local minima of the cost between any two runs."""
    leaves, arrives = [], []
    for a in runs:
        for b in runs:
            block = costs[a.start : a.stop, b.start : b.stop].copy()
            block[~np.isfinite(block)] = np.inf
            if a == b:
                block[np.subtract.outer(np.arange(len(a)), np.arange(len(a))) <= 0] = (
                    np.inf
                )  # the way on is the capture
            rows, columns = np.nonzero((block == minimum_filter(block, 3, mode="nearest")) & np.isfinite(block))
            leaves.append(rows + a.start)
            arrives.append(columns + b.start)
    return np.concatenate(leaves), np.concatenate(arrives)


def essential_against_motion_graph(quick: bool, picture: Path | None) -> list[Figure]:
    """B Fig. 6 on the procedural performance, with B's bounds of 1/3 to 2 seconds."""
    capture, poses, _, _ = performance(200 if quick else 400)
    distances, runs, n = pose_distances(poses), capture.runs(), len(capture)
    shortest, longest = round(capture.fps / 3), round(2 * capture.fps)
    longest = min(longest, max(len(run) for run in runs))
    figures, curves = [], []
    for alpha in (0.01, 0.1):
        costs = complete_costs(distances, runs, alpha, shortest, longest)
        found = essential_graph(costs, runs, alpha)
        step = np.rint(alpha / QUANTUM)
        ours = dijkstra(way_costs(n, runs, step, found.leaves, found.arrives, found.cost / QUANTUM)) * QUANTUM
        complete = dijkstra(np.where(np.eye(n, dtype=bool), np.inf, costs)) * QUANTUM
        finite = np.isfinite(complete)
        difference = float(np.abs(ours[finite] - complete[finite]).max())
        if not np.array_equal(np.isfinite(ours), finite):
            difference = np.inf
        leaves, arrives = local_minima(costs, runs)
        theirs = dijkstra(way_costs(n, runs, step, leaves, arrives, costs[leaves, arrives])) * QUANTUM
        pairs = ~np.eye(n, dtype=bool) & finite
        cheaper = float((ours[pairs] < theirs[pairs]).mean())
        dearer = float((ours[pairs] > theirs[pairs]).mean())
        both = pairs & np.isfinite(theirs)
        print(
            f"\nalpha {alpha:g}: essential {len(found.leaves)} transitions, motion graph {len(leaves)}; {cheaper:.1%} "
            f"of all pairs get cheaper; mean cost {ours[both].mean():.3f} against {theirs[both].mean():.3f}; "
            f"{float((pairs & ~np.isfinite(theirs)).sum() / pairs.sum()):.1%} have no way in the motion graph"
        )
        curves.append((alpha, np.sort(ours[pairs]), np.sort(theirs[pairs])))
        figures += [
            figure(
                f"distances in the essential and the complete graph differ, alpha {alpha:g}",
                difference,
                "",
                0.0,
                difference == 0,
            ),
            figure(f"pairs that get cheaper than in a motion graph, alpha {alpha:g}", 100 * cheaper, "%", None, None),
            figure(f"pairs that get dearer, alpha {alpha:g}", 100 * dearer, "%", 0.0, dearer == 0),
        ]
    if picture is not None:
        picture.write_text(cost_curves(curves))
    return figures


def cost_curves(curves: list[tuple[float, np.ndarray, np.ndarray]]) -> str:
    """B Fig. 6 as SVG: the costs of all pairs, sorted, one panel for each alpha."""
    width, height, parts = 420, 300, []
    for panel, (alpha, ours, theirs) in enumerate(curves):
        left = 60 + panel * (width + 70)
        top = np.nanmax(np.where(np.isfinite(theirs), theirs, np.nan))
        for name, color, values in (("essential graph", "#0a7", ours), ("motion graph", "#c40", theirs)):
            values = values[np.isfinite(values)]
            at = np.linspace(0, len(values) - 1, 300).astype(int)
            points = " ".join(
                f"{left + width * i / len(ours):.1f},{20 + height * (1 - values[i] / top):.1f}" for i in at
            )
            parts.append(f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="2"/>')
            line = 40 if name.startswith("e") else 58
            parts.append(f'<text x="{left + 10}" y="{line}" fill="{color}">{name}</text>')
        parts.append(f'<rect x="{left}" y="20" width="{width}" height="{height}" fill="none" stroke="#888"/>')
        parts.append(f'<text x="{left}" y="{height + 40}">pairs of frames, sorted; alpha {alpha:g}</text>')
        parts.append(f'<text x="{left - 5}" y="30" text-anchor="end">{top:.2g}</text>')
        parts.append(f'<text x="{left - 5}" y="{height + 20}" text-anchor="end">0</text>')
    body = "".join(parts)
    size = f'width="{60 + len(curves) * (width + 70)}" height="{height + 60}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="13">{body}</svg>\n'


def essential_time(quick: bool) -> list[Figure]:
    """The essential graph of a capture like B's larger one: 2,600 frames in ten clips, at 30 frames a second."""
    n = 390 if quick else 2600
    random = np.random.default_rng(0)
    poses = np.cumsum(random.normal(scale=0.02, size=(n, 20)), axis=0) * 0.2
    runs = [range(first, first + n // 10) for first in range(0, n, n // 10)]
    distances = pose_distances(poses)
    began, cpu = time.perf_counter(), time.process_time()
    with ProcessPoolExecutor(2) as executor:
        costs = complete_costs(distances, runs, 0.02, 10, 60, executor=executor)
    middle = time.perf_counter()
    found = essential_graph(costs, runs, 0.02)
    total, own = time.perf_counter() - began, time.process_time() - cpu
    print(
        f"\n{n} frames: {middle - began:.1f} s for all transitions on two cores, {total:.1f} s in all (wall), "
        f"{len(found.leaves)} transitions kept; {own:.1f} s of CPU outside the workers"
    )
    reach = None if quick else 600.0
    return [
        figure(
            f"essential graph of {n} frames, wall seconds on two cores",
            total,
            "s",
            reach,
            None if quick else total <= 600,
        )
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a few graphs and queries in place of all")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    parser.add_argument("--picture", type=Path, help="draw B Fig. 6 into this file, as SVG")
    parser.add_argument("--only", choices=list(PARTS), help="one part of all")
    arguments = parser.parse_args()
    figures = []
    for name, part in PARTS.items():
        if arguments.only in (None, name):
            more = (arguments.picture,) if part is essential_against_motion_graph else ()
            figures += part(arguments.quick, *more)
    print()
    for entry in figures:
        print(
            f"{entry['name']}: {entry['value']:.3g} {entry['unit']} (reach {entry['reach']}, holds: {entry['holds']})"
        )
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n")


def figure(name: str, value: float, unit: str, reach: float | None, holds: bool | None) -> Figure:
    return {
        "name": name,
        "value": float(value),
        "unit": unit,
        "reach": reach,
        "holds": None if holds is None else bool(holds),
    }


PARTS = {
    "probabilities": probabilities,
    "lengths": exact_lengths,
    "queries": distance_and_time,
    "essential": essential_against_motion_graph,
    "time": essential_time,
}


if __name__ == "__main__":
    main()
