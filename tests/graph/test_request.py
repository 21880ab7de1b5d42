import numpy as np
import pytest
from toy_graph import least_costs, placed_case, played_names, random_case

from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.exact_length import LengthTable
from unstructured_mg.graph.floor_track import floor_track, track_length
from unstructured_mg.graph.motion_graph import build_graph
from unstructured_mg.graph.request import PathRequest, find_path
from unstructured_mg.graph.routes import build_routes

CAPTURE, GRAPH = placed_case(2, 90, 4, k=2)
A, B = int(GRAPH.frames[3]), int(GRAPH.frames[-2])


def metres(found):
    points, _ = floor_track(GRAPH.places, GRAPH.links, found.path.segments)
    return track_length(np.concatenate([GRAPH.places.captured[found.path.start][None], points]))


def cost(found):
    links = [s.link for s in found.path.segments if s.link is not None]
    return sum(GRAPH.links[link].cost for link in links)


def test_a_length_that_is_possible_is_met_at_least_cost():
    least = least_costs(GRAPH, CAPTURE, A, B, 200)
    for frames in np.flatnonzero(np.isfinite(least))[::7].tolist():
        found = find_path(GRAPH, CAPTURE, PathRequest(A, B, frames=frames + 1))
        assert found.remark is None and found.world == PlanarRigid() and not found.loop
        assert (found.path.start, found.path.goal, len(found.path)) == (A, B, frames)
        assert cost(found) == pytest.approx(least[frames])


def test_one_that_is_not_gives_the_nearest_and_says_so():
    least = least_costs(GRAPH, CAPTURE, A, B, 200)
    frames = int(np.flatnonzero(np.isinf(least))[-1])
    found = find_path(GRAPH, CAPTURE, PathRequest(A, B, frames=frames + 1))
    off = len(found.path) - frames
    assert off != 0 and found.remark == (
        f"The nearest possible length is {len(found.path) + 1} frames, {abs(off)} frame{'s' * (abs(off) > 1)} "
        f"{'more' if off > 0 else 'fewer'}."
    )


def test_a_distance_is_met_and_the_remark_tells_how_nearly():
    found = find_path(GRAPH, CAPTURE, PathRequest(A, B, distance=4.0))
    off = metres(found) - 4.0
    assert abs(off) < 0.3
    assert f"covers {metres(found):.2f} m, {100 * abs(off):.0f} cm {'more' if off > 0 else 'less'}" in found.remark
    timed = find_path(GRAPH, CAPTURE, PathRequest(A, B, distance=4.0, frames=120))
    assert f", in {len(timed.path) + 1} frames" in timed.remark


def test_loops_end_where_they_begin_and_are_as_long_as_asked():
    found = find_path(GRAPH, CAPTURE, PathRequest(loop=True, frames=100))
    assert found.loop and found.path.start == found.path.goal and found.remark is None and len(found.path) == 100
    # No other node has a cheaper one.
    for node in GRAPH.nodes.tolist():
        routes = build_routes(GRAPH, CAPTURE, node, node)
        assert LengthTable(routes).upto(100)[100, routes.start] >= cost(found) - 1e-12
    shortest = find_path(GRAPH, CAPTURE, PathRequest(A, loop=True))
    lengths = np.flatnonzero(np.isfinite(least_costs(GRAPH, CAPTURE, A, A, 200)))
    assert len(shortest.path) == lengths[1] and shortest.path.goal == A
    frames = int(lengths[lengths > 90][0])
    near = find_path(GRAPH, CAPTURE, PathRequest(A, loop=True, frames=frames, within=50.0))
    assert near.path.goal == A and near.remark is None and len(near.path) == frames
    far = find_path(GRAPH, CAPTURE, PathRequest(A, loop=True, distance=5.0))
    assert far.path.goal == A and "covers" in far.remark


def test_a_radius_that_is_too_small_is_missed_by_as_little_as_can_be():
    found = find_path(GRAPH, CAPTURE, PathRequest(A, frames=80, within=0.01))
    points, _ = floor_track(GRAPH.places, GRAPH.links, found.path.segments)
    radius = np.linalg.norm(points - GRAPH.places.captured[A], axis=1).max()
    assert len(found.path) == 79
    assert found.remark == (
        f"The nearest path found gets {radius:.2f} m away from its start, {100 * (radius - 0.01):.0f} cm more than "
        "asked for."
    )
    assert find_path(GRAPH, CAPTURE, PathRequest(A, frames=80, within=radius + 1e-6)).remark is None


def test_poses_come_at_their_times():
    middle = int(GRAPH.frames[len(GRAPH.frames) // 2])
    wanted = ((1.0, A), (3.0, middle), (5.5, B))
    found = find_path(GRAPH, CAPTURE, PathRequest(poses=wanted))
    names = [A, *played_names(GRAPH, found.path.segments)]
    said = found.remark or ""
    for seconds, frame in wanted:
        time = round((seconds - 1.0) * 30)
        if f"frame {CAPTURE.frame_id(frame)} is shown" not in said:
            assert names[time] == frame
    assert names[-1] == B


def test_a_curve_is_followed_from_wherever_is_best():
    curve = np.array([[2.0, 2.0], [2.0, 3.5]])
    best = find_path(GRAPH, CAPTURE, PathRequest(curve=curve))
    given = find_path(GRAPH, CAPTURE, PathRequest(A, curve=curve))
    assert "strays from the curve of 1.50 m by" in best.remark and given.path.start == A
    assert best.path.start in GRAPH.nodes
    assert np.isclose(metres(given), 1.5, atol=0.2)


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        (PathRequest(A, loop=True, goal=B), "--loop and --to"),
        (PathRequest(curve=np.eye(2), frames=10), "--curve and --frames or --seconds"),
        (PathRequest(curve=np.eye(2), poses=((0, A), (1, B))), "do not go together"),
        (PathRequest(A, poses=((0, A), (1, B))), "--poses and --from"),
        (PathRequest(A, within=1.0, distance=3.0, frames=9), "--within and --distance"),
        (PathRequest(A, within=1.0), "needs --frames or --seconds"),
        (PathRequest(A), "needs --to"),
        (PathRequest(), "needs --from and --to"),
        (PathRequest(goal=B, distance=3.0), "needs --from"),
        (PathRequest(loop=True), "needs --from"),
        (PathRequest(curve=np.ones((3, 2))), "the curve: points"),
    ],
)
def test_what_makes_no_sense_is_said_in_a_sentence(request_, words):
    with pytest.raises(UserError, match=words):
        find_path(GRAPH, CAPTURE, request_)


def test_without_places_what_needs_them_is_refused_and_the_rest_works():
    capture, links = random_case(0)
    graph = build_graph(capture, links)
    start, goal = int(graph.frames[0]), int(graph.frames[-1])
    assert len(find_path(graph, capture, PathRequest(start, goal, frames=300)).path) > 200
    with pytest.raises(UserError, match="says nothing of places"):
        find_path(graph, capture, PathRequest(start, goal, distance=3.0))


def test_where_nothing_leads_back_it_is_said():
    capture, line = placed_case(0, 40, 0)
    for asked in (PathRequest(20, 3, frames=9), PathRequest(20, 3, distance=1.0), PathRequest(5, loop=True)):
        with pytest.raises(UserError, match="no transition leads back"):
            find_path(line, capture, asked)


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"frames": 0}, "frames"),
        ({"distance": float("inf")}, "distance"),
        ({"within": -1.0}, "within"),
        ({"curve": np.zeros((1, 2))}, "curve"),
        ({"poses": ((1.0, 3), (0.0, 4))}, "poses"),
    ],
)
def test_values_out_of_range_name_themselves(given, name):
    with pytest.raises(ValueError, match=f"^{name}"):
        PathRequest(**given)
