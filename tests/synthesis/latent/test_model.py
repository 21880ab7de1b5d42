from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from toy_latent import curved_model

from unstructured_mg.synthesis.latent.network import Network


def test_no_solver_finds_a_better_latent_from_the_same_start():
    model = curved_model()
    shapes = model.decode(np.random.default_rng(6).normal(size=(5, 3))) + 0.01
    found = model.encode(shapes)
    wanted = (shapes - model.mean).reshape(5, -1) @ model.basis.T / model.scale

    def residual(latent, row):
        return np.concatenate([model.decoder(latent[None])[0] - wanted[row], np.sqrt(model.ridge) * latent])

    for row, latent in enumerate(found):
        cost = (residual(latent, row) ** 2).sum()
        assert cost <= (residual(model.encode(shapes[row : row + 1], refine=False)[0], row) ** 2).sum()
        best = least_squares(residual, latent, args=(row,))
        assert cost <= 2 * best.cost * (1 + 1e-4) + 1e-12


def test_latents_of_decoded_shapes_are_found_again():
    model = replace(curved_model(), ridge=0.0)
    latents = 0.1 * np.random.default_rng(7).normal(size=(5, 3))
    exact = replace(model, encoder=Network(np.zeros((3, 5)), np.zeros(3)))
    decoded = exact.decode(exact.encode(exact.decode(latents)))
    np.testing.assert_allclose(decoded, exact.decode(latents), atol=1e-3)


def test_wrong_shapes_are_named():
    model = curved_model()
    with pytest.raises(ValueError, match=r"shapes: expected shape \(f, 4, 3\), got \(4, 3\)"):
        model.encode(np.zeros((4, 3)))
    with pytest.raises(ValueError, match=r"latents: expected shape \(f, 3\), got \(2, 4\)"):
        model.decode(np.zeros((2, 4)))
