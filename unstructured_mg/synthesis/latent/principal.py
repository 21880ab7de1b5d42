"""Principal components of shapes: the basis of every latent model, and the baseline beside R's autoencoder."""

import numpy as np

from unstructured_mg.synthesis.latent.model import LatentModel
from unstructured_mg.synthesis.latent.network import Network


def span_of(offsets: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Orthonormal rows ``(q, w) float32`` that span ``offsets`` (f, w), those that carry most first.

    Principal directions of the rows weighted by ``weights`` (f,), by the eigenvectors of their f x f Gram matrix:
    there are far fewer shapes than coordinates. Directions below the rounding of float32 are left out.
    """
    rows = weights[:, None] * offsets
    values, vectors = np.linalg.eigh(rows @ rows.T)
    order = np.argsort(-values, kind="stable")
    order = order[values[order] > 1e-10 * values[order[0]]]
    basis = (vectors[:, order] / np.sqrt(values[order])).T @ rows
    # An eigenvector's sign is the library's whim; the larger half of each row is made positive.
    signs = np.where(np.einsum("qw,qw->q", basis, np.abs(basis)) < 0, -1.0, 1.0)
    return (signs[:, None] * basis).astype(np.float32)


def principal_model(shapes: np.ndarray, faces: np.ndarray, size: int) -> LatentModel:
    """The ``size`` principal components of centred ``shapes`` (f, n, 3) as a latent model; latents have deviation 1.

    Fewer where the shapes span fewer. Raises ValueError where all shapes are one.
    """
    mean = shapes.mean(axis=0)
    offsets = (shapes - mean).reshape(len(shapes), -1)
    if np.abs(offsets).max() <= 1e-9 * np.abs(shapes).max():
        raise ValueError("shapes: expected at least two that differ")
    basis = span_of(offsets, np.ones(len(offsets)))[:size]
    coefficients = offsets @ basis.T
    scale = float(coefficients[:, 0].std())
    deviation = coefficients.std(axis=0) / scale
    none = np.zeros(len(basis))
    return LatentModel(
        faces,
        mean,
        basis,
        scale,
        Network(np.diag(1 / deviation), none),
        Network(np.diag(deviation), none),
        0.0,
    )
