"""Options of a latent model."""

from dataclasses import dataclass

KINDS = ("variational", "principal")


@dataclass(frozen=True)
class LatentOptions:
    """How a latent model is made. All values are JSON-ready.

    kind : "variational" (R section 3.3) or "principal": components of the same number, the baseline
    size : dimensions of the latent space; R tries 16 to 256
    hidden : width of the two hidden layers of encoder and decoder; R Table 2's decoders have about 300
    epochs : passes over all frames at most; R takes 10 000 of stochastic gradient descent, Adam needs fewer
    rate : Adam's first step size, which falls to 0 along a cosine
    prior : weight of the Kullback-Leiber term relative to R eq. 4. At 1 the prior holds the latents of 135 frames too
        tightly: the error on held-out frames of mit_crane at 8 dimensions is 1.44 % there and 1.18 % at 0.01
    exchanges : shapes to learn from beside the captured ones, each with limbs exchanged between captured frames; 0 for
        R's own training
    exchange_weight : weight of all of them together against all captured frames
    seed : of all random choices
    """

    kind: str = "variational"
    size: int = 16
    hidden: int = 256
    epochs: int = 3000
    rate: float = 1e-3
    prior: float = 0.01
    exchanges: int = 600
    exchange_weight: float = 2.0
    seed: int = 0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"kind: expected one of {', '.join(KINDS)}, got {self.kind!r}")
        for name, least in (("size", 1), ("hidden", 1), ("epochs", 1), ("exchanges", 0), ("seed", 0)):
            value = getattr(self, name)
            if not isinstance(value, int) or value < least:
                raise ValueError(f"{name}: expected a whole number not below {least}, got {value!r}")
        for name in ("rate", "prior", "exchange_weight"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name}: expected a number not below 0, got {getattr(self, name)!r}")
