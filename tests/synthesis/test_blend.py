import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from toy_pair import bend, bending_pair, club

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.synthesis import blend_latent
from unstructured_mg.synthesis.align import align_windows
from unstructured_mg.synthesis.blend import BLENDS, blend_postures, blend_windows
from unstructured_mg.synthesis.latent.options import LatentOptions
from unstructured_mg.synthesis.options import BLEND_NAMES, SynthesisOptions
from unstructured_mg.synthesis.posture import Posture
from unstructured_mg.synthesis.quality import volume
from unstructured_mg.synthesis.weights import cubic_weights

STIFF = ("volumetric_arap", "surface_arap", "poisson")


def posture(template, angle, rotation=None):
    turn = np.eye(3) if rotation is None else Rotation.from_rotvec(rotation).as_matrix()
    return Posture(bend(template.surface, angle) @ turn.T, bend(template.cage, angle) @ turn.T)


@pytest.fixture(autouse=True)
def little_training(monkeypatch):
    """What is asked of every blend holds for a latent one after any training."""
    monkeypatch.setattr(blend_latent, "OPTIONS", LatentOptions(size=3, hidden=8, epochs=100, exchanges=2))


def test_the_registry_has_the_names_of_the_options():
    assert set(BLENDS) == set(BLEND_NAMES)


@pytest.mark.parametrize("name", BLEND_NAMES)
def test_both_ends_are_met(name):
    template = club()
    blend = BLENDS[name](template)
    source, target = posture(template, 0.3), posture(template, 1.4, [0.2, 0.4, 0.6])
    np.testing.assert_allclose(blend(source, target, 0.0).surface, source.surface, atol=1e-9)
    np.testing.assert_allclose(blend(source, target, 1.0).surface, target.surface, atol=1e-9)


@pytest.mark.parametrize("name", BLEND_NAMES)
def test_swapping_the_ends_changes_nothing(name):
    template = club()
    blend = BLENDS[name](template)
    source, target = posture(template, -0.4), posture(template, 1.4, [0.2, 0.4, 0.6])
    np.testing.assert_allclose(blend(source, target, 0.3).surface, blend(target, source, 0.7).surface, atol=1e-9)


@pytest.mark.parametrize(("name", "precision"), [("volumetric_arap", 1e-9), ("poisson", 1e-9), ("surface_arap", 1e-2)])
def test_a_turn_by_ninety_degrees_keeps_the_shape_and_is_halved(name, precision):
    """Surface ARAP starts from the shrunken linear blend, as in the paper: 20 iterations are not enough."""
    template = club()
    source, target = posture(template, 0.0), posture(template, 0.0, [0, np.pi / 2, 0])
    middle = BLENDS[name](template)(source, target, 0.5).surface
    centred, rest = middle - middle.mean(0), template.surface - template.surface.mean(0)
    turn, _ = Rotation.align_vectors(centred, rest)
    np.testing.assert_allclose(centred, turn.apply(rest), atol=precision)
    np.testing.assert_allclose(turn.as_rotvec(), [0, np.pi / 4, 0], atol=0.05)


def test_the_linear_blend_shrinks_a_turned_club_as_the_cosine_says():
    template = club()
    source, target = posture(template, 0.0), posture(template, 0.0, [0, np.pi / 2, 0])
    middle = BLENDS["linear"](template)(source, target, 0.5).surface
    length = np.linalg.norm(middle[template.surface[:, 2].argmax()] - middle[template.surface[:, 2].argmin()])
    np.testing.assert_allclose(length, np.cos(np.pi / 4), rtol=1e-12)


@pytest.mark.parametrize("name", STIFF)
def test_a_bend_is_halved(name):
    """Between straight and bent by 1.6 rad lies bent by 0.8 rad: lengths and volume kept, where linear loses them."""
    template = club()
    source, target = posture(template, 0.0), posture(template, 1.6)
    middle = BLENDS[name](template)(source, target, 0.5).surface
    truth = bend(template.surface, 0.8)
    between = (source.surface + target.surface) / 2

    def apart(shape):
        shape, goal = shape - shape.mean(0), truth - truth.mean(0)
        turn, _ = Rotation.align_vectors(goal, shape)
        return np.sqrt(((turn.apply(shape) - goal) ** 2).sum(1).mean())

    assert apart(middle) < 0.1 * apart(between)
    expected = (volume(source.surface, template.faces) + volume(target.surface, template.faces)) / 2
    assert abs(volume(middle, template.faces) / expected - 1) < 0.01


def test_a_transition_meets_the_tracked_windows():
    pair = bending_pair(4, np.linspace(0, 0.4, 9), np.linspace(0.5, 1.2, 9), PlanarRigid(1.0, 2.0, 3.0))
    alignment = align_windows(pair)
    for reverse in (False, True):
        steps = blend_windows(pair, alignment, SynthesisOptions(), reverse)
        source, target = pair.vertices[:9], alignment.apply(pair.vertices[9:])
        if reverse:
            source, target = pair.vertices[9:], alignment.inverse().apply(pair.vertices[:9])
        assert steps.shape == source.shape
        np.testing.assert_allclose(steps[0], source[0], atol=1e-9)
        np.testing.assert_allclose(steps[-1], target[-1], atol=1e-9)


def test_every_step_blends_the_windows_frames_of_that_step():
    pair = bending_pair(4, np.linspace(0, 0.4, 9), np.linspace(0.5, 1.2, 9), PlanarRigid(1.0, 2.0, 3.0))
    alignment = align_windows(pair)
    steps = blend_windows(pair, alignment, SynthesisOptions(blend="linear"), False)
    weights = cubic_weights(4)[:, None, None]
    expected = (1 - weights) * pair.vertices[:9] + weights * alignment.apply(pair.vertices[9:])
    np.testing.assert_allclose(steps, expected, atol=1e-12)


def test_identical_windows_give_themselves_back():
    angles = np.linspace(0, 0.6, 7)
    pair = bending_pair(3, angles, angles, PlanarRigid(-2.0, 1.0, 1.0))
    for name in BLEND_NAMES:
        steps = blend_windows(pair, align_windows(pair), SynthesisOptions(blend=name), False)
        np.testing.assert_allclose(steps, pair.vertices[:7], atol=1e-8)


def test_cells_stay_upright():
    pair = bending_pair(4, np.linspace(-1.2, -0.8, 9), np.linspace(0.8, 1.2, 9))
    for step in blend_postures(pair, PlanarRigid(), SynthesisOptions(), False):
        assert tet_volumes(step.cage, pair.tets).min() > 0
