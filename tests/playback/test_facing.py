import numpy as np
import pytest
from memory_capture import box

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.playback.facing import facing


def joined(*meshes):
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    return vertices, np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)])


def fine_box(size, at):
    """A box in slices, so that every height has faces."""
    slices = 60
    parts = [
        box((0, 0, 0), (size[0], size[1], size[2] / slices), (at[0], at[1], at[2] + size[2] * i / slices))
        for i in range(slices)
    ]
    return parts


@pytest.mark.parametrize("turn", [0.0, 1.0, 3.0, -2.0])
def test_a_closed_figure_faces_where_its_toes_point(turn):
    legs = [part for x in (-0.1, 0.1) for part in fine_box((0.1, 0.1, 0.9), (x, 0, 0))]
    feet = [box((0, 0, 0), (0.09, 0.26, 0.06), (x, -0.08, 0)) for x in (-0.1, 0.1)]
    vertices, faces = joined(*legs, *feet, box((0, 0, 0), (0.4, 0.25, 0.9), (0, 0, 0.9)))
    found = facing(PlanarRigid(turn).apply(vertices), faces)
    assert np.cos(found - (turn - np.pi / 2)) > 0.999


@pytest.mark.parametrize("turn", [0.0, 2.0])
def test_an_open_surface_faces_along_its_net_normal(turn):
    angle, height = np.meshgrid(np.linspace(-1.2, 1.2, 20), np.linspace(0, 0.5, 6))
    vertices = np.stack([0.2 * np.cos(angle), 0.2 * np.sin(angle), height], axis=-1).reshape(-1, 3)
    corner = np.arange(5 * 20).reshape(5, 20)[:, :-1].ravel()
    faces = np.concatenate(
        [np.stack([corner, corner + 1, corner + 21], 1), np.stack([corner, corner + 21, corner + 20], 1)]
    )
    found = facing(PlanarRigid(turn).apply(vertices), faces)
    assert np.cos(found - turn) > 0.999


def test_without_a_hint_the_usual_front_is_taken():
    vertices, faces = joined(*fine_box((0.3, 0.3, 1.0), (0, 0, 0)))
    assert facing(vertices, faces) == -np.pi / 2
