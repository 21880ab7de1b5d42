"""Training of R's variational autoencoder (R section 3.3), in the coordinates of the shapes' own span."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from unstructured_mg.errors import UserError
from unstructured_mg.synthesis.latent.network import Network
from unstructured_mg.synthesis.latent.options import LatentOptions
from unstructured_mg.synthesis.latent.tensors import packed, unpacked

if TYPE_CHECKING:
    import torch

# Every so many epochs the unseen frames are tried, the state is written, and progress is told.
INTERVAL = 100
# Training ends where the unseen frames did not get better for so many intervals.
PATIENCE = 10
VALIDATION = 0.1
SAMPLES = 128
DECAY = 1e-3
# The encoder's deviations begin at exp(-1.5): the decoder sees the frames apart from each other from the start.
FIRST_LOG_VARIANCE = -3.0

Progress = Callable[[int, int], None]
Keep = Callable[[bytes], None]


def train(
    captured: np.ndarray,
    exchanged: np.ndarray,
    prior: float,
    options: LatentOptions,
    state: bytes | None = None,
    keep: Keep | None = None,
    progress: Progress | None = None,
) -> tuple[Network, Network]:
    """Encoder and decoder for coefficients ``captured`` (f, q) and, beside them, ``exchanged`` (a, q).

    Minimises the mean over captured frames of |c - decoder(z)|^2 + prior KL(N(m, s) || N(0, 1)), z drawn from the
    encoder's N(m, s) (R eq. 4), plus ``options.exchange_weight`` times the same mean over exchanged shapes, by Adam.
    A tenth of the captured frames, drawn at random, is only looked at: the state that does best on it is
    the result, and training ends early where it does not improve (R: "optimised through validation data").
    Begins at the principal components.

    ``keep`` is given the state of training from time to time; from such a ``state`` training goes on, and the result is
    that of an unbroken run. Runs on a GPU where there is one. Raises UserError where torch is not installed.
    """
    torch = require_torch()
    threads = torch.get_num_threads()
    torch.set_num_threads(1)  # the same sums in the same order on every machine
    try:
        return _Training(torch, captured, exchanged, prior, options).run(state, keep, progress)
    finally:
        torch.set_num_threads(threads)


def require_torch() -> Any:
    """The torch module. Raises UserError where it is not installed."""
    try:
        import torch
    except ImportError:
        raise UserError(
            "latent models are learnt with torch, which is not installed; run pip install 'unstructured_mg[learn]'."
        ) from None
    return torch


class _Training:
    """The networks, the optimiser's state, and where training stands."""

    def __init__(self, torch: Any, captured: np.ndarray, exchanged: np.ndarray, prior: float, options: LatentOptions):
        self.torch, self.options, self.prior = torch, options, prior
        self.device = "cuda" if torch.cuda.is_available() else "cpu"
        random = np.random.default_rng(options.seed)
        order = random.permutation(len(captured))
        unseen = max(1, round(VALIDATION * len(captured)))
        self.seen, self.unseen = self._tensor(captured[np.sort(order[unseen:])]), self._tensor(captured[order[:unseen]])
        self.exchanged = self._tensor(exchanged)
        self.random = torch.Generator().manual_seed(options.seed)
        self.values = self._start(captured)
        for value in self.values.values():
            value.requires_grad_(True)
        self.optimiser = torch.optim.AdamW(list(self.values.values()), lr=options.rate, weight_decay=DECAY)
        self.epoch, self.stale, self.best_error = 0, 0, math.inf
        self.best = {name: value.detach().clone() for name, value in self.values.items()}

    def run(self, state: bytes | None, keep: Keep | None, progress: Progress | None) -> tuple[Network, Network]:
        if state is not None:
            self._resume(state)
        while self.epoch < self.options.epochs and self.stale < PATIENCE:
            self._step()
            if self.epoch % INTERVAL == 0 or self.epoch == self.options.epochs:
                self._look()
                if keep is not None:
                    keep(self._state())
                if progress is not None:
                    progress(self.epoch, self.options.epochs)
        if progress is not None:
            progress(self.options.epochs, self.options.epochs)
        return self._networks()

    def _start(self, captured: np.ndarray) -> "dict[str, torch.Tensor]":
        """Principal components on the straight way, small random layers beside it."""
        q, d, h = captured.shape[1], min(self.options.size, *captured.shape), self.options.hidden
        centre = captured - captured.mean(axis=0)
        _, _, directions = np.linalg.svd(centre, full_matrices=False)
        directions = directions[:d]
        deviation = np.maximum((centre @ directions.T).std(axis=0), 1e-6)
        values = {
            "encoder.weight": directions / deviation[:, None],
            "encoder.bias": np.zeros(d),
            "decoder.weight": directions.T * deviation,
            "decoder.bias": np.zeros(q),
        }
        for name, widths in (("encoder", (q, h, h, 2 * d)), ("decoder", (d, h, h, q))):
            for layer, (fan_in, fan_out) in enumerate(zip(widths[:-1], widths[1:], strict=True)):
                bound = (0.1 if layer == 2 else 1.0) / math.sqrt(fan_in)
                random = self.torch.rand((fan_out, fan_in + 1), generator=self.random, dtype=self.torch.float64)
                drawn = bound * (2 * random.numpy() - 1)
                values[f"{name}.{layer}.weight"], values[f"{name}.{layer}.bias"] = drawn[:, :-1], drawn[:, -1]
        return {name: self._tensor(value) for name, value in values.items()}

    def _step(self) -> None:
        torch = self.torch
        for group in self.optimiser.param_groups:
            group["lr"] = self.options.rate * 0.5 * (1 + math.cos(math.pi * self.epoch / self.options.epochs))
        batch, weight = self.seen, torch.full((len(self.seen),), 1 / len(self.seen), device=self.device)
        if len(self.exchanged):
            drawn = torch.randint(len(self.exchanged), (SAMPLES,), generator=self.random)
            batch = torch.cat([batch, self.exchanged[drawn.to(self.device)]])
            each = self.options.exchange_weight / SAMPLES
            weight = torch.cat([weight, torch.full((SAMPLES,), each, device=self.device)])
        mean, log_variance = self._encode(batch)
        noise = torch.randn(mean.shape, generator=self.random).to(self.device)
        latents = mean + noise * torch.exp(log_variance / 2)
        distance = ((self._through("decoder", latents) - batch) ** 2).sum(dim=1)
        divergence = 0.5 * (mean**2 + log_variance.exp() - 1 - log_variance).sum(dim=1)
        loss = (weight * (distance + self.prior * divergence)).sum()
        self.optimiser.zero_grad()
        loss.backward()
        self.optimiser.step()
        self.epoch += 1

    def _look(self) -> None:
        with self.torch.no_grad():
            mean, _ = self._encode(self.unseen)
            error = float(((self._through("decoder", mean) - self.unseen) ** 2).sum(dim=1).mean())
        if error < self.best_error:
            self.best_error, self.stale = error, 0
            self.best = {name: value.detach().clone() for name, value in self.values.items()}
        else:
            self.stale += 1

    def _encode(self, batch: "torch.Tensor") -> "tuple[torch.Tensor, torch.Tensor]":
        """Means and logarithms of the variances of the latents (f, d)."""
        layers = self._layers("encoder", batch)
        d = layers.shape[1] // 2
        straight = batch @ self.values["encoder.weight"].T + self.values["encoder.bias"]
        return straight + layers[:, :d], FIRST_LOG_VARIANCE + layers[:, d:]

    def _through(self, name: str, x: "torch.Tensor") -> "torch.Tensor":
        return x @ self.values[f"{name}.weight"].T + self.values[f"{name}.bias"] + self._layers(name, x)

    def _layers(self, name: str, x: "torch.Tensor") -> "torch.Tensor":
        for layer in range(3):
            if layer:
                x = self.torch.nn.functional.elu(x)
            x = x @ self.values[f"{name}.{layer}.weight"].T + self.values[f"{name}.{layer}.bias"]
        return x

    def _networks(self) -> tuple[Network, Network]:
        found = {name: value.cpu().numpy().astype(np.float64) for name, value in self.best.items()}
        d = len(found["encoder.bias"])
        networks = []
        for name, rows in (("encoder", slice(0, d)), ("decoder", slice(None))):
            layers = [(found[f"{name}.{layer}.weight"], found[f"{name}.{layer}.bias"]) for layer in range(3)]
            layers[-1] = (layers[-1][0][rows], layers[-1][1][rows])
            networks.append(Network(found[f"{name}.weight"], found[f"{name}.bias"], tuple(layers)))
        return networks[0], networks[1]

    def _state(self) -> bytes:
        tensors = {"random": self.random.get_state().numpy()}
        tensors["where"] = np.array([self.epoch, self.stale, self.best_error])
        for name, value in self.values.items():
            state = self.optimiser.state[value]
            tensors[f"value/{name}"] = value.detach().cpu().numpy()
            tensors[f"best/{name}"] = self.best[name].cpu().numpy()
            tensors[f"first/{name}"] = state["exp_avg"].cpu().numpy()
            tensors[f"second/{name}"] = state["exp_avg_sq"].cpu().numpy()
        return packed(tensors, {})

    def _resume(self, state: bytes) -> None:
        torch = self.torch
        tensors, _ = unpacked(state, "the state of training")
        self.random.set_state(torch.from_numpy(tensors["random"]))
        epoch, stale, self.best_error = tensors["where"].tolist()
        self.epoch, self.stale = int(epoch), int(stale)
        for name, value in self.values.items():
            with torch.no_grad():
                value.copy_(torch.from_numpy(tensors[f"value/{name}"]))
            self.best[name] = self._tensor(tensors[f"best/{name}"])
            self.optimiser.state[value] = {
                "step": torch.tensor(float(self.epoch)),
                "exp_avg": self._tensor(tensors[f"first/{name}"]),
                "exp_avg_sq": self._tensor(tensors[f"second/{name}"]),
            }

    def _tensor(self, values: np.ndarray) -> "torch.Tensor":
        return self.torch.tensor(np.array(values), dtype=self.torch.float32, device=self.device)
