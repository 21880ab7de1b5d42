"""A small fully connected network with a straight way past it, evaluated in NumPy: playing needs no torch."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Network:
    """y = W x + b + M(x), M a chain of affine layers with exponential linear units (ELU) between them.

    R's layers are leaky rectifiers; the ELU is smooth, which the refinement of a latent needs. The straight way lets
    training begin at principal components. Without ``layers`` the map is affine.

    Attributes
    ----------
    weight : (o, i) float64
    bias : (o,) float64
    layers : pairs of weight (o', i') and bias (o',); the first takes i, the last gives o
    """

    weight: np.ndarray
    bias: np.ndarray
    layers: tuple[tuple[np.ndarray, np.ndarray], ...] = ()

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Values ``(f, o)`` at ``x`` (f, i)."""
        return self.value_and_slope(x, slope=False)[0]

    def value_and_slope(self, x: np.ndarray, slope: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Values ``(f, o)`` and derivatives ``(f, o, i)`` at ``x`` (f, i); no derivatives (0, o, i) on request."""
        straight = x @ self.weight.T + self.bias
        count = len(x) if slope else 0
        total = np.broadcast_to(self.weight, (count, *self.weight.shape))
        if not self.layers:
            return straight, total
        value = x
        chain = np.broadcast_to(np.eye(x.shape[1]), (count, x.shape[1], x.shape[1]))
        for number, (weight, bias) in enumerate(self.layers):
            if number:
                below = np.exp(np.minimum(value, 0))
                if slope:
                    chain = np.where(value > 0, 1.0, below)[:, :, None] * chain
                value = np.where(value > 0, value, below - 1)
            value = value @ weight.T + bias
            chain = weight @ chain
        return straight + value, total + chain
