"""Frames of one connectivity in, a latent model out (R section 3)."""

from collections.abc import Callable

import numpy as np

from unstructured_mg.synthesis.latent.centre import centre_all
from unstructured_mg.synthesis.latent.exchange import Exchange
from unstructured_mg.synthesis.latent.model import LatentModel
from unstructured_mg.synthesis.latent.options import LatentOptions
from unstructured_mg.synthesis.latent.principal import principal_model, span_of
from unstructured_mg.synthesis.latent.train import Keep, train

LEAST_FRAMES = 10

Progress = Callable[[int, int], None]


def learn(
    vertices: np.ndarray,
    faces: np.ndarray,
    options: LatentOptions,
    *,
    state: bytes | None = None,
    keep: Keep | None = None,
    progress: Progress | None = None,
) -> LatentModel:
    """A latent model of frames ``vertices`` (f, n, 3) float64, metres, with ``faces`` (m, 3) int32.

    ``state`` and ``keep``: see ``train``. Latent dimensions are at most f - 1. Raises ValueError for fewer than ten
    frames, and UserError where torch is needed and not installed.
    """
    if vertices.ndim != 3 or vertices.shape[2] != 3 or len(vertices) < LEAST_FRAMES:
        raise ValueError(f"vertices: expected shape (at least {LEAST_FRAMES}, n, 3), got {vertices.shape}")
    shapes, mean = centre_all(vertices)
    if options.kind == "principal":
        return principal_model(shapes, faces, options.size)
    offsets = (shapes - mean).reshape(len(shapes), -1)
    made = exchanged_offsets(shapes, faces, options)
    # As in training, all exchanged shapes together weigh exchange_weight, and all captured ones 1.
    share = np.sqrt(options.exchange_weight * len(offsets) / max(len(made), 1))
    basis = span_of(np.concatenate([offsets, made]), np.r_[np.ones(len(offsets)), np.full(len(made), share)])
    basis = basis[: 2 * len(offsets)]
    coefficients = offsets @ basis.T
    scale = float(coefficients.std(axis=0).max())
    # R scales coordinates to [-1, 1]; eq. 4 then weighs the divergence 1 against the sum over a frame's coordinates.
    prior = options.prior * (float(np.abs(shapes).max()) / scale) ** 2
    encoder, decoder = train(
        coefficients / scale, (made @ basis.T) / scale, prior, options, state=state, keep=keep, progress=progress
    )
    return LatentModel(faces, mean, basis, scale, encoder, decoder, prior)


def exchanged_offsets(shapes: np.ndarray, faces: np.ndarray, options: LatentOptions) -> np.ndarray:
    """``options.exchanges`` shapes with exchanged limbs, less the mean, one a row."""
    if not options.exchanges:
        return np.zeros((0, shapes[0].size))
    exchange = Exchange(shapes, faces)
    random = np.random.default_rng(options.seed)
    return np.stack([(exchange.draw(random) - exchange.mean).ravel() for _ in range(options.exchanges)])
