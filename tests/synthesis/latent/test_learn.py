import numpy as np
import pytest
from toy_pair import bend, club

from unstructured_mg.errors import UserError
from unstructured_mg.synthesis.latent import train as training
from unstructured_mg.synthesis.latent.centre import centre_all
from unstructured_mg.synthesis.latent.learn import learn
from unstructured_mg.synthesis.latent.options import LatentOptions
from unstructured_mg.synthesis.latent.principal import principal_model

SMALL = LatentOptions(size=1, hidden=32, epochs=600, exchanges=0)


@pytest.fixture(scope="module")
def bending():
    """A club that bends: one parameter, and a curve in the space of shapes."""
    template = club()
    return np.stack([bend(template.surface, angle) for angle in np.linspace(-1.5, 1.51, 31)]), template.faces


def error(model, shapes):
    return np.sqrt(((model.decode(model.encode(shapes)) - shapes) ** 2).sum(axis=2).mean())


def test_one_latent_holds_a_curve_that_one_component_cannot(bending):
    vertices, faces = bending
    shapes, _ = centre_all(vertices)
    held = np.zeros(len(shapes), bool)
    held[3::5] = True
    model = learn(vertices[~held], faces, SMALL)
    assert model.size == 1
    assert error(model, shapes[held]) < 0.3 * error(principal_model(shapes[~held], faces, 1), shapes[held])


def test_training_goes_on_from_a_kept_state_as_if_it_had_not_stopped(bending):
    vertices, faces = bending
    states = []
    whole = learn(vertices, faces, SMALL, keep=states.append)
    assert len(states) > 2
    resumed = learn(vertices, faces, SMALL, state=states[1])
    np.testing.assert_array_equal(whole.decoder.weight, resumed.decoder.weight)
    for first, second in zip(whole.decoder.layers, resumed.decoder.layers, strict=True):
        np.testing.assert_array_equal(first[0], second[0])


def test_progress_ends_at_the_whole(bending):
    told = []
    learn(*bending, LatentOptions(size=1, hidden=4, epochs=150, exchanges=3), progress=lambda *now: told.append(now))
    assert told[-1] == (150, 150)


def test_too_few_frames_are_refused(bending):
    vertices, faces = bending
    with pytest.raises(ValueError, match=r"vertices: expected shape \(at least 10, n, 3\), got \(9, 642, 3\)"):
        learn(vertices[:9], faces, SMALL)


def test_missing_torch_names_the_remedy(bending, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "torch", None)
    with pytest.raises(UserError, match=r"pip install 'unstructured_mg\[learn\]'"):
        learn(*bending, SMALL)
    assert training.PATIENCE > 0
