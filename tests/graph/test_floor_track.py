import numpy as np
import pytest
from toy_graph import placed_case

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.graph.floor_track import floor_track, moved, track_length


def by_hand(graph, segments):
    """Frame by frame, with matrices."""
    world, points = np.eye(4), []
    for segment in segments:
        link = None if segment.link is None else graph.links[segment.link]
        for i in range(segment.first, segment.last + 1):
            own = graph.places.captured[i] if link is None else graph.places.steps[segment.link][i + link.k - 1]
            points.append((world @ [*own, 0, 1])[:2])
        if link is not None:
            world = world @ link.alignment.matrix()
    return np.array(points), world


@pytest.mark.parametrize("seed", range(3))
def test_every_frame_stands_where_the_walk_puts_it(seed):
    _, graph = placed_case(seed)
    for edge in graph.edges:
        points, motion = floor_track(graph.places, graph.links, edge.segments)
        expected, world = by_hand(graph, edge.segments)
        np.testing.assert_allclose(points, expected, atol=1e-12)
        np.testing.assert_allclose(motion.matrix(), world, atol=1e-12)
        np.testing.assert_allclose(edge.transform.matrix(), world, atol=1e-12)


def test_lengths_and_motions():
    assert track_length(np.array([[0, 0], [3, 4], [3, 5]])) == 6
    np.testing.assert_allclose(moved(np.array([1.0, 0.0]), PlanarRigid(np.pi / 2, 2, 3)), [2, 4])
