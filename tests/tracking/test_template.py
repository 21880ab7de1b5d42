import numpy as np
from tracking.bodies import tube
from tracking.walkers import swaying

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.template import select_template, template_rank


def torus(major, minor, n, m):
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    ring = major + minor * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), minor * np.sin(v)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    return vertices, faces.astype(np.int32)


def joined(*meshes):
    vertices, faces, start = [], [], 0
    for points, triangles in meshes:
        vertices.append(points)
        faces.append(triangles + start)
        start += len(points)
    return np.concatenate(vertices), np.concatenate(faces).astype(np.int32)


def test_components_genus_and_area_of_known_bodies():
    ball, ring = tube(0.3, 0.2, 30, 5), torus(1.0, 0.2, 60, 20)
    assert template_rank(*ball, 0.01)[:2] == (1, 0)
    assert template_rank(*ring, 0.01)[:2] == (1, -1)
    np.testing.assert_allclose(template_rank(*ring, 0.01)[2], 4 * np.pi**2 * 0.2, rtol=0.02)
    away = (ball[0] + 5, ball[1])
    assert template_rank(*joined(ring, away), 0.01)[:2] == (2, -1)
    # Split seams, a hole, and repeated faces change neither count.
    split = (ring[0][ring[1]].reshape(-1, 3), np.arange(3 * len(ring[1]), dtype=np.int32).reshape(-1, 3))
    assert template_rank(*split, 0.01)[:2] == (1, -1)
    assert template_rank(ball[0], ball[1][5:], 0.01)[:2] == (1, 0)
    assert template_rank(ring[0], np.concatenate([ring[1], ring[1][:, ::-1]]), 0.01)[:2] == (1, -1)


class Frames:
    def __init__(self, meshes):
        self.meshes = meshes

    def read(self, index):
        return TexturedMesh(*self.meshes[index])


def test_components_win_over_genus_over_area_and_debris_counts_for_nothing():
    ball, ring = tube(0.3, 0.2, 30, 5), torus(1.0, 0.2, 60, 20)
    large = (ball[0] * 1.1, ball[1])
    crumb = (ball[0] * 0.01 + 3, ball[1])
    second = (ball[0] * 0.9 + 5, ball[1])
    candidate = Candidate(0, 1, 0.0, 0.0, 0)

    def choose(*meshes):
        return select_template(Frames(meshes), candidate, TrackingOptions())

    assert choose(ball, large) == 1
    assert choose(ring, ball) == 1
    assert choose(large, joined(ball, crumb)) == 0
    assert choose(joined(ring, second), large) == 0
    assert choose(ball, ball) == 0


def test_every_frame_of_both_windows_is_looked_at():
    capture = swaying(20)
    chosen = select_template(capture, Candidate(4, 14, 0.0, 0.0, 2), TrackingOptions())
    areas = {
        frame: template_rank(capture.read(frame).vertices, capture.read(frame).faces, 0.01)
        for frame in [2, 3, 4, 5, 6, 12, 13, 14, 15, 16]
    }
    assert areas[chosen] == max(areas.values())
