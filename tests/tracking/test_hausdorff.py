import numpy as np
from tracking.bodies import tube

from unstructured_mg.tracking.hausdorff import surface_distance
from unstructured_mg.tracking.surface import clean_surface, vertex_areas
from unstructured_mg.tracking.target import Target


def test_distances_between_concentric_tubes_are_their_gap():
    inner, faces = tube(0.20, 1.0, 60, 20)
    outer, outer_faces = tube(0.21, 1.0, 60, 20)
    target = Target(clean_surface(outer, outer_faces), 0.05, 0.1)
    distance = surface_distance(inner, faces, vertex_areas(inner, faces), target)
    np.testing.assert_allclose([distance.largest, distance.mean, distance.p95], 0.01, rtol=0.02)


def test_what_only_one_surface_has_counts_both_ways():
    body, faces = tube(0.2, 1.0, 40, 20)
    ball, ball_faces = tube(0.1, 0.1, 20, 4)
    both = np.concatenate([body, ball + [0, 0.5, 0]]), np.concatenate([faces, ball_faces + len(body)]).astype(np.int32)
    target = Target(clean_surface(*both), 0.05, 0.1)
    missing = surface_distance(body, faces, vertex_areas(body, faces), target)
    assert 0.35 < missing.largest < 0.41
    alone = Target(clean_surface(body, faces), 0.05, 0.1)
    extra = surface_distance(*both, vertex_areas(*both), alone)
    np.testing.assert_allclose(extra.largest, missing.largest, rtol=1e-3)
