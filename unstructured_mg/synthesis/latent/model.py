"""A latent model: shapes to latent vectors and back (R section 3)."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.synthesis.latent.network import Network

# Levenberg-Marquardt on a latent: few steps settle it, since the encoder's answer is near.
STEPS = 30
SETTLED = 1e-6


@dataclass(frozen=True)
class LatentModel:
    """Encoder and decoder between centred shapes of one connectivity and latent vectors.

    A shape is mean + scale basis^T c. The basis spans every shape that the model was made from, so nothing of them is
    lost in c; the first and the last fully connected layer of R's networks are the products of the networks' own and
    the basis. Gradients of a loss on the training shapes lie in that span anyway.

    Attributes
    ----------
    faces : (m, 3) int32
    mean : (n, 3) float64, metres
    basis : (q, 3 n) float32, orthonormal rows
    scale : metres; coefficients c are of order 1
    encoder : coefficients (q) to latent means (d)
    decoder : latents (d) to coefficients (q)
    ridge : weight of |z|^2 against |c - decoder(z)|^2 in ``encode``: the Gaussian prior over the latents
    """

    faces: np.ndarray
    mean: np.ndarray
    basis: np.ndarray
    scale: float
    encoder: Network
    decoder: Network
    ridge: float

    @property
    def size(self) -> int:
        """Dimensions of the latent space."""
        return self.decoder.weight.shape[1]

    def encode(self, shapes: np.ndarray, refine: bool = True) -> np.ndarray:
        """Latents ``(f, d) float64`` of centred ``shapes`` (f, n, 3).

        The encoder's answer, refined to minimise |c - decoder(z)|^2 + ridge |z|^2, of which the encoder is only a
        quick guess; not refined on request.
        """
        if shapes.ndim != 3 or shapes.shape[1:] != self.mean.shape:
            raise ValueError(f"shapes: expected shape (f, {len(self.mean)}, 3), got {shapes.shape}")
        wanted = (shapes - self.mean).reshape(len(shapes), -1) @ self.basis.T / self.scale
        latents = self.encoder(wanted)
        return self._refined(latents, wanted) if refine and self.decoder.layers else latents

    def decode(self, latents: np.ndarray) -> np.ndarray:
        """Centred shapes ``(f, n, 3) float64`` of ``latents`` (f, d)."""
        if latents.ndim != 2 or latents.shape[1] != self.size:
            raise ValueError(f"latents: expected shape (f, {self.size}), got {latents.shape}")
        moved = self.scale * (self.decoder(latents) @ self.basis)
        return self.mean + moved.reshape(len(latents), *self.mean.shape)

    def _refined(self, latents: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """Levenberg-Marquardt, all frames side by side, each with its own damping."""
        damping = np.full(len(latents), 1e-2)
        value, slope = self.decoder.value_and_slope(latents)
        cost = self._cost(latents, value, wanted)
        going = np.ones(len(latents), bool)
        for _ in range(STEPS):
            normal = slope.transpose(0, 2, 1) @ slope + self.ridge * np.eye(self.size)
            pull = np.einsum("foi,fo->fi", slope, wanted - value) - self.ridge * latents
            level = damping * np.trace(normal, axis1=1, axis2=2) / self.size
            step = np.linalg.solve(normal + level[:, None, None] * np.eye(self.size), pull[:, :, None])[:, :, 0]
            tried = latents + step
            tried_value, tried_slope = self.decoder.value_and_slope(tried)
            tried_cost = self._cost(tried, tried_value, wanted)
            better = going & (tried_cost < cost)
            settled = better & (cost - tried_cost < SETTLED * cost)
            latents = np.where(better[:, None], tried, latents)
            value = np.where(better[:, None], tried_value, value)
            slope = np.where(better[:, None, None], tried_slope, slope)
            cost = np.where(better, tried_cost, cost)
            damping = np.where(better, 0.3 * damping, 4 * damping)
            going &= ~settled
            if not going.any():
                break
        return latents

    def _cost(self, latents: np.ndarray, value: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        return ((value - wanted) ** 2).sum(axis=1) + self.ridge * (latents**2).sum(axis=1)
