import numpy as np
import pytest

from unstructured_mg.playback.site_mesh import draw_order, quantised


def random_surface(seed, materials):
    random = np.random.default_rng(seed)
    faces = random.integers(0, 40, (90, 3)).astype(np.int32)
    face_uv = random.integers(0, 70, (90, 3)).astype(np.int32)
    return faces, face_uv, random.integers(0, materials, 90).astype(np.int32) if materials > 1 else None


@pytest.mark.parametrize("materials", [1, 3])
def test_every_face_keeps_its_corners_and_its_orientation(materials):
    faces, face_uv, material = random_surface(0, materials)
    drawing = draw_order(faces, face_uv, material, materials)
    assert sorted(drawing.source_face) == list(range(90))
    for position, source in enumerate(drawing.source_face):
        corner = drawing.faces[position]
        drawn = list(zip(drawing.vertex_of[corner], drawing.uv_of[corner], strict=True))
        captured = list(zip(faces[source], face_uv[source], strict=True))
        assert drawn in (captured, captured[1:] + captured[:1], captured[2:] + captured[:2])
    pairs = set(zip(drawing.vertex_of, drawing.uv_of, strict=True))
    assert len(pairs) == len(drawing.vertex_of)
    assert pairs == set(zip(faces.ravel(), face_uv.ravel(), strict=True))
    if material is not None:
        np.testing.assert_array_equal(material[drawing.source_face], np.sort(material))
        assert drawing.faces_of_material == tuple(np.bincount(material, minlength=materials))


def test_without_uv_corners_are_vertices():
    faces, _, _ = random_surface(1, 1)
    drawing = draw_order(faces, np.zeros((0, 3), np.int32), None, 0)
    assert sorted(drawing.vertex_of) == sorted(set(faces.ravel())) and len(drawing.uv_of) == 0
    np.testing.assert_array_equal(np.sort(drawing.vertex_of[drawing.faces], 1), np.sort(faces[drawing.source_face], 1))


def test_neighbours_in_a_grid_are_neighbours_in_the_file():
    """Cuthill-McKee's order of a shuffled 40 x 40 grid: no edge spans more corners than a diagonal row has."""
    side = 40
    start = np.arange(side * (side - 1)).reshape(side - 1, side)[:, :-1].ravel()
    faces = np.concatenate(
        [np.stack([start, start + 1, start + side], 1), np.stack([start + 1, start + side + 1, start + side], 1)]
    )
    shuffled = np.random.default_rng(0).permutation(side * side)[faces].astype(np.int32)
    drawing = draw_order(shuffled, shuffled[:0], None, 0)
    assert np.ptp(drawing.faces, axis=1).max() <= 2 * side


@pytest.mark.parametrize(("extent", "step"), [(1.8, 1e-4), (65.535, 1e-3)])
def test_steps_are_as_fine_as_asked_or_as_16_bits_allow(extent, step):
    points = np.random.default_rng(0).random((500, 3)) * extent - 7
    points[:2] = [[-7] * 3, [extent - 7] * 3]
    steps, low, size = quantised(points, 1e-4)
    assert steps.dtype == np.uint16 and size == pytest.approx(step)
    assert np.abs(low + size * steps - points).max() <= size / 2 * (1 + 1e-9)
