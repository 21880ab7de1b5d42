import numpy as np

from unstructured_mg.capture.atlas import SAMPLES, coverage


def test_triangles_that_tile_cover_each_sample_once():
    side = np.linspace(0.1, 0.9, 9)
    uv = np.stack(np.meshgrid(side, side), axis=2).reshape(-1, 2)
    corner = np.arange(81).reshape(9, 9)
    a, b, c, d = (x.ravel() for x in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([c, a, d])[::-1]])  # of both orientations
    counts = coverage(uv, faces)
    assert counts.shape == (1, SAMPLES, SAMPLES) and counts.max() == 1
    assert abs(counts.mean() - 0.64) < 0.01


def test_counts_are_those_of_every_triangle_tested_at_every_sample():
    rng = np.random.default_rng(0)
    uv = rng.uniform(-0.3, 1.3, (60, 2))
    faces = rng.integers(0, 60, (40, 3))
    material = rng.integers(0, 2, 40)
    sample = (np.arange(SAMPLES) + 0.5 - 1 / np.pi**4) / SAMPLES
    x, y = np.meshgrid(sample, sample)
    expected = np.zeros((2, SAMPLES, SAMPLES), int)
    for triangle, index in zip(uv[faces], material, strict=True):
        matrix = np.column_stack([triangle[1] - triangle[0], triangle[2] - triangle[0]])
        if abs(np.linalg.det(matrix)) < 1e-12:
            continue
        s, t = np.linalg.inv(matrix) @ np.stack([x.ravel() - triangle[0, 0], y.ravel() - triangle[0, 1]])
        expected[index] += ((s > 0) & (t > 0) & (s + t < 1)).reshape(x.shape)
    np.testing.assert_array_equal(coverage(uv, faces, material), expected)


def test_hostile_uvs_are_counted_inside_the_image_only():
    """A triangle a billion images wide, many times over: walking through all of it would never end."""
    uv = np.array([[-1e9, -1e9], [1e9, 0.0], [0.5, 1e9]])
    assert (coverage(uv, np.tile([[0, 1, 2]], (100_000, 1))) > 1).all()
