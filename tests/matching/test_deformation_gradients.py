import numpy as np
import pytest
import scipy.linalg
from array_capture import array_capture, figure

from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.matching.deformation_gradients import STRETCH, fit
from unstructured_mg.matching.dissimilarity import compute_dissimilarity
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.matching.window import spline_weights

OPTIONS = MatchingOptions(descriptor="deformation_gradients", k=2, velocity_seconds=0.0)


def swinging(count, seed=0):
    """Frames of one connectivity that swing, stretch and wander; all triangles move as those of a body do."""
    rng = np.random.default_rng(seed)
    frames = []
    for i in range(count):
        vertices, faces = figure(0.4 * i, 0.15 * i, (0.1 * i, rng.random(), 0), seed=0)
        frames.append((vertices * [1.0, 1.0, 1.0 + 0.02 * np.sin(i)] + rng.normal(0, 1e-4, vertices.shape), faces))
    return frames


def literal_distance(first, second, faces, yaw):
    """B equations 1 to 3 as they stand, with SciPy's polar decomposition and logarithm; the mean over triangles."""
    second = PlanarRigid(yaw).apply(second)

    def gradient_basis(vertices, face):
        a, b, c = vertices[face]
        normal = np.cross(a - c, b - c)
        return np.stack([a - c, b - c, normal / np.linalg.norm(normal)], axis=1)

    terms = []
    for face in faces:
        source, target = gradient_basis(first, face), gradient_basis(second, face)
        rotation, stretch = scipy.linalg.polar(target @ np.linalg.inv(source))
        back = scipy.linalg.polar(source @ np.linalg.inv(target))[1]
        angle = np.linalg.norm(scipy.linalg.logm(rotation).real) / np.sqrt(2)
        stretches = np.linalg.norm(stretch - np.eye(3)) + np.linalg.norm(back - np.eye(3))
        terms.append(angle + STRETCH * stretches / 2)
    return np.mean(terms)


def test_equals_the_papers_equations_with_one_yaw_a_window(tmp_path):
    frames = swinging(12)
    capture = array_capture(frames)
    found = compute_dissimilarity(capture, OPTIONS, scratch=tmp_path)
    layout = fit(capture, np.zeros((12, 5)))
    faces = layout.faces[layout.sampled[::16]]
    for s, t in ((2, 3), (3, 9)):
        yaw = found.yaw[s, t]
        distances = [literal_distance(frames[s + l][0], frames[t + l][0], faces, yaw) for l in range(-2, 3)]
        expected = np.sqrt(spline_weights(2) @ np.square(distances))
        assert found.scores[s, t] == pytest.approx(expected, rel=0.03)  # a sixteenth of the sampled triangles
        # The yaw is the one that aligns the sampled triangles' centres over the window.
        weights = layout.weights

        def residual(turn, s=s, t=t, weights=weights):
            total = 0.0
            for w, l in zip(spline_weights(2), range(-2, 3), strict=True):
                a, b = (frames[i + l][0][layout.faces[layout.sampled]].mean(axis=1)[:, :2] for i in (s, t))
                a, b = a - weights @ a, b - weights @ b
                c, d = np.cos(turn), np.sin(turn)
                total += w * (weights @ ((a - b @ np.array([[c, d], [-d, c]])) ** 2).sum(axis=1))
            return total

        assert residual(yaw) <= min(residual(yaw - 1e-3), residual(yaw + 1e-3))
    np.testing.assert_array_equal(found.scores, found.scores.T)
    assert found.unit == "rad"


def test_sampled_triangles_stand_for_all(tmp_path):
    frames = swinging(6)
    capture = array_capture(frames)
    options = MatchingOptions(descriptor="deformation_gradients", k=1, velocity_seconds=0.0)
    found = compute_dissimilarity(capture, options, scratch=tmp_path)
    layout = fit(capture, np.zeros((6, 5)))
    assert len(layout.sampled) == 1024 < len(layout.faces) and len(set(layout.sampled.tolist())) == 1024
    every = layout.faces[np.random.default_rng(0).permutation(len(layout.faces))[:200]]
    between = [literal_distance(frames[1 + l][0], frames[3 + l][0], every, found.yaw[1, 3]) for l in (-1, 0, 1)]
    assert found.scores[1, 3] == pytest.approx(np.sqrt(spline_weights(1) @ np.square(between)), rel=0.05)


def test_a_motion_turned_and_moved_is_the_same(tmp_path):
    frames = swinging(5)
    motion = PlanarRigid(2.2, 1.0, -3.0)
    turned = [(motion.apply(vertices), faces) for vertices, faces in frames]
    capture = array_capture(frames + turned, clips=[("a", range(5)), ("b", range(5))])
    found = compute_dissimilarity(capture, OPTIONS, scratch=tmp_path)
    assert found.scores[2, 7] < 1e-3
    assert found.yaw[2, 7] == pytest.approx(-2.2, abs=1e-4)


def test_the_first_frame_of_another_connectivity_is_named(tmp_path):
    frames = swinging(6)
    frames[3] = (frames[3][0], frames[3][1][:, [1, 2, 0]])
    frames[4] = figure(0.0, seed=9)
    with pytest.raises(UserError, match=r"clip/3\.obj: has another connectivity than 0\.obj.*--descriptor"):
        compute_dissimilarity(array_capture(frames), OPTIONS, scratch=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_flat_triangles_and_small_meshes_do_no_harm(tmp_path):
    frames = []
    for i in range(3):
        vertices = np.random.default_rng(i).random((5, 3))
        vertices[4] = vertices[3]
        frames.append((vertices, np.array([[0, 1, 2], [0, 2, 3], [2, 3, 4]], np.int32)))
    found = compute_dissimilarity(
        array_capture(frames), MatchingOptions(descriptor="deformation_gradients", k=1), scratch=tmp_path
    )
    assert found.scores[1, 1] == 0 and found.k[1, 1] == 1
