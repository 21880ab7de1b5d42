"""A small network, and a latent model around it, with random weights."""

import numpy as np

from unstructured_mg.synthesis.latent.model import LatentModel
from unstructured_mg.synthesis.latent.network import Network


def random_network(layers: bool, seed: int = 0) -> Network:
    random = np.random.default_rng(seed)
    widths = (3, 7, 6, 5)
    chain = tuple(
        (0.4 * random.normal(size=(b, a)), random.normal(size=b)) for a, b in zip(widths[:-1], widths[1:], strict=True)
    )
    return Network(random.normal(size=(5, 3)), random.normal(size=5), chain if layers else ())


def curved_model() -> LatentModel:
    decoder = random_network(True)
    random = np.random.default_rng(5)
    basis, _ = np.linalg.qr(random.normal(size=(12, 5)))
    encoder = Network(random.normal(size=(3, 5)), np.zeros(3))
    mean = random.normal(size=(4, 3))
    return LatentModel(np.array([[0, 1, 2]], np.int32), mean, basis.T.astype(np.float32), 0.5, encoder, decoder, 1e-3)
