import numpy as np
import pytest
from tracking.bodies import bend, figure, tube

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.tracking.cage import build_cage
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.register_surface import register_surface

OPTIONS = TrackingOptions(cage_vertices=400)


def joined(*parts: tuple[np.ndarray, np.ndarray]) -> TexturedMesh:
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [faces + start for (_, faces), start in zip(parts, starts, strict=False)]
    return TexturedMesh(np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces).astype(np.int32))


def ball(around: int, centre: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """An egg, so that its turn can be seen."""
    vertices, faces = tube(0.12, 0.06, around, 7)
    return vertices * [1.0, 1.1, 0.9] + centre, faces


def moved_by(result, source: TexturedMesh) -> np.ndarray:
    return np.linalg.norm(result.vertices - source.vertices, axis=1)


def test_a_person_and_a_ball_go_their_own_ways():
    source = joined(figure(40, 60), ball(40, [0.6, 0.2, 0.4]))
    target = joined(figure(53, 71), ball(47, [0.6, 0.2, 0.4]))
    people = len(figure(53, 71)[0])

    def move(points: np.ndarray, first_of_ball: int) -> np.ndarray:
        return np.concatenate([bend(points[:first_of_ball], 0.4), points[first_of_ball:] + [0.05, -0.06, 0.12]])

    goal = TexturedMesh(move(target.vertices, people), target.faces)
    result = register_surface(source, goal, OPTIONS)
    truth = move(source.vertices, len(figure(40, 60)[0]))
    error = np.linalg.norm(result.vertices - truth, axis=1)
    assert result.refusal is None and result.inverted_tets == 0 and result.tracked.all()
    assert np.sqrt(np.mean(error**2)) < 6e-3 and error.max() < 2e-2
    assert np.linalg.norm(source.vertices - truth, axis=1).max() > 0.2


def test_holes_fins_debris_and_doubled_faces_are_survived():
    vertices, faces = figure(40, 60)
    centres = vertices[faces].mean(1)
    holes = np.linalg.norm(centres - vertices[900], axis=1) < 0.05
    holes |= np.linalg.norm(centres - vertices[1500], axis=1) < 0.04
    fin = np.array([[*faces[1000][:2], 700], [faces[1000][1], faces[1000][0], faces[1000][2]]])
    debris = np.array([[1, 1, 1], [1.01, 1, 1], [1, 1.01, 1], [1, 1, 1.01]], float)
    debris_faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]) + len(vertices)
    source = TexturedMesh(
        np.concatenate([vertices, debris, [[0.0, 0.0, 5.0]]]),
        np.concatenate([faces[~holes], fin, debris_faces]).astype(np.int32),
    )
    other, other_faces = figure(53, 71)
    result = register_surface(source, TexturedMesh(bend(other, 0.3), other_faces), OPTIONS)
    used = np.unique(source.faces[: -len(debris_faces)])
    np.testing.assert_array_equal(np.flatnonzero(result.tracked), used)
    error = np.linalg.norm(result.vertices - bend(source.vertices, 0.3), axis=1)[used]
    assert np.isfinite(result.vertices).all()
    assert np.sqrt(np.mean(error**2)) < 6e-3


def test_the_yaw_and_the_place_of_a_target_elsewhere_are_made_up_for():
    source, (other, faces) = TexturedMesh(*figure(40, 60)), figure(53, 71)
    c, s = np.cos(1.2), np.sin(1.2)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])

    def move(points: np.ndarray) -> np.ndarray:
        return bend(points, 0.2) @ turn.T + [3.0, -2.0, 0.0]

    cage = build_cage(source, OPTIONS)
    result = register_surface(source, TexturedMesh(move(other), faces), OPTIONS, cage=cage, yaw=1.0)
    error = np.linalg.norm(result.vertices - move(source.vertices), axis=1)
    assert result.refusal is None and result.cage is cage
    assert np.sqrt(np.mean(error**2)) < 6e-3


def test_a_component_that_vanishes_is_refused_with_the_distance():
    person = figure(40, 60)
    source, target = joined(person, ball(40, [0.7, 0.2, 0.4])), TexturedMesh(*person)
    for first, second in ((source, target), (target, source)):
        result = register_surface(first, second, OPTIONS)
        assert result.refusal is not None and result.refusal.stage == "tracking"
        assert result.refusal.measures["hausdorff_m"] == result.distance.largest > OPTIONS.hausdorff_m
        assert f"{100 * result.distance.largest:.1f} cm" in result.refusal.reason
        # The person, who is in both, is where they were.
        assert moved_by(result, first)[: len(person[0])].max() < 1e-2


def test_what_is_reached_by_stretching_alone_is_refused():
    vertices, faces = figure(40, 60)
    other, other_faces = figure(53, 71)
    small, larger = 0.05 * (vertices - [0, 0, 0.9]), 0.08 * (other - [0, 0, 0.9])
    result = register_surface(TexturedMesh(small, faces), TexturedMesh(larger, other_faces), OPTIONS)
    assert result.distance.largest < OPTIONS.hausdorff_m
    assert result.refusal is not None and "stretched" in result.refusal.reason
    assert result.refusal.measures["stretch_p95"] == result.stretch > OPTIONS.stretch


@pytest.mark.parametrize("shape", ["triangle", "sheet"])
def test_surfaces_without_volume_are_followed(shape):
    if shape == "triangle":
        source = TexturedMesh(np.array([[0.0, 0, 1], [1, 0, 1], [0, 1, 1]]), np.array([[0, 1, 2]], np.int32))
    else:
        x, y = (a.ravel() for a in np.meshgrid(np.arange(20) / 20, np.arange(20) / 20, indexing="ij"))
        corner = (np.arange(19)[:, None] * 20 + np.arange(19)).ravel()
        faces = [[corner, corner + 20, corner + 21], [corner, corner + 21, corner + 1]]
        source = TexturedMesh(
            np.stack([x, y, 1 + 0.05 * np.sin(5 * x)], 1),
            np.concatenate([np.stack(f, 1) for f in faces]).astype(np.int32),
        )
    result = register_surface(source, TexturedMesh(source.vertices + [0.0, 0.0, 0.03], source.faces), OPTIONS)
    np.testing.assert_allclose(result.vertices, source.vertices + [0.0, 0.0, 0.03], atol=2e-3)


GOOD = TexturedMesh(*figure(20, 30))
NOT_FINITE = GOOD.vertices.copy()
NOT_FINITE[3, 1] = np.nan
BAD = {
    "no vertices": (np.zeros((0, 3)), GOOD.faces, "faces"),
    "no faces": (GOOD.vertices, np.zeros((0, 3), np.int32), "faces"),
    "not finite": (NOT_FINITE, GOOD.faces, "vertices"),
    "flat vertices": (GOOD.vertices[:, :2], GOOD.faces, "vertices"),
    "words": (GOOD.vertices.astype(str), GOOD.faces, "vertices"),
    "complex": (GOOD.vertices.astype(complex), GOOD.faces, "vertices"),
    "quads": (GOOD.vertices, np.zeros((5, 4), np.int32), "faces"),
    "fractions": (GOOD.vertices, GOOD.faces.astype(float), "faces"),
    "out of range": (GOOD.vertices, GOOD.faces + len(GOOD.vertices), "faces"),
    "negative": (GOOD.vertices, GOOD.faces - 1, "faces"),
    "no area": (np.zeros_like(GOOD.vertices), GOOD.faces, "faces"),
}


@pytest.mark.parametrize("fault", BAD)
def test_bad_surfaces_are_named_with_what_was_expected_and_given(fault):
    vertices, faces, argument = BAD[fault]
    bad = TexturedMesh(vertices, faces)
    with pytest.raises(ValueError, match=rf"^source\.{argument}: expected .* got "):
        register_surface(bad, GOOD, OPTIONS)
    with pytest.raises(ValueError, match=rf"^target\.{argument}: expected .* got "):
        register_surface(GOOD, bad, OPTIONS)


def test_a_cage_of_another_surface_and_a_yaw_that_is_no_angle_are_refused():
    with pytest.raises(ValueError, match="cage: expected"):
        register_surface(GOOD, GOOD, OPTIONS, cage=build_cage(TexturedMesh(*figure(22, 30)), OPTIONS))
    with pytest.raises(ValueError, match="yaw: expected"):
        register_surface(GOOD, GOOD, OPTIONS, yaw=np.nan)
