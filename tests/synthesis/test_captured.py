import dataclasses

import numpy as np
import trimesh
from textured_pairs import ArrayCapture
from toy_pair import bending_pair

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.synthesis.captured import colour_change, end_steps, surface_change, surface_distance
from unstructured_mg.synthesis.texture_options import TextureOptions


def test_distance_between_spheres_is_the_difference_of_their_radii():
    ball = trimesh.creation.icosphere(subdivisions=4)
    faces = np.asarray(ball.faces, np.int32)
    debris = np.array([[50.0, 0, 0], [50.001, 0, 0], [50, 0.001, 0]])
    vertices = np.concatenate([ball.vertices, debris])
    with_debris = np.concatenate([faces, [[len(ball.vertices), len(ball.vertices) + 1, len(ball.vertices) + 2]]])
    found = surface_distance(vertices, with_debris.astype(np.int32), 1.1 * ball.vertices, faces)
    np.testing.assert_allclose(found, 0.1, rtol=0.02)


def frames_of(pair, colours):
    meshes = [TexturedMesh(v, pair.faces, colors=c) for v, c in zip(pair.vertices, colours, strict=True)]
    return ArrayCapture(meshes), dataclasses.replace(pair, frames=np.arange(len(meshes)))


def test_neighbours_at_the_ends_of_both_windows():
    pair = bending_pair(2)
    assert end_steps(pair) == [(0, 1), (3, 4), (5, 6), (8, 9)]
    # Seven source frames and four target frames.
    warp = np.array([[0, 1, 2, 3, 4, 5, 6], [7, 7, 8, 9, 9, 10, 10]], np.int32)
    warped = dataclasses.replace(pair, k=3, frames=np.arange(11), warp=warp)
    assert end_steps(warped) == [(0, 1), (5, 6), (7, 8), (9, 10)]


def test_the_largest_change_at_the_ends_counts():
    pair = bending_pair(2, np.zeros(5), np.array([0.0, 0.0, 0.5, 0.5, 0.5]))
    grown = pair.vertices.copy()
    grown[8] *= [1.1, 1.1, 1.0]
    pair = dataclasses.replace(pair, vertices=grown)
    capture, pair = frames_of(pair, [None] * 10)
    expected = surface_distance(grown[8], pair.faces, grown[9], pair.faces)
    assert 0.005 < expected < 0.011
    assert surface_change(capture, pair) == expected
    assert colour_change(capture, pair, TextureOptions()) is None


def test_colours_are_compared_at_the_same_places_of_the_surface():
    pair = bending_pair(2, np.linspace(0, 0.1, 5), np.linspace(0, 0.1, 5))
    base = np.full((len(pair.vertices[0]), 3), 100, np.uint8)
    colours = [base] * 10
    colours[1] = base + np.array([6, 0, 0], np.uint8)
    capture, pair = frames_of(pair, colours)
    np.testing.assert_allclose(colour_change(capture, pair, TextureOptions()), 2.0, atol=1e-4)
