"""Transition probabilities that visit the captured frames as evenly as possible (P section 7.1)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.stationary import Chain

Objective = Callable[[np.ndarray], tuple[float, np.ndarray]]


@dataclass(frozen=True)
class Traffic:
    """The contracted graph as the objective sees it.

    Each of the N nodes is one captured frame, and edge e holds ``inner[e]`` further captured frames: all of them are
    visited as often as the edge is taken. So sums over the n captured frames become weighted sums over nodes and edges.
    Synthesized frames are not counted: what is to be even is the use that is made of the capture.

    Attributes
    ----------
    chain : the chain's pattern: ``chain.source``, ``chain.target`` (E,), ``chain.nodes`` N
    inner : (E,) float64
    ways : (N,) out-edges of each node
    node_pull : (N,) float64, 1 / w of each node's frame, w the share of a walk's captured frames that is wanted of it
    edge_pull : (E,) float64, 1 / w added up over the frames inside each edge
    """

    chain: Chain
    inner: np.ndarray
    ways: np.ndarray
    node_pull: np.ndarray
    edge_pull: np.ndarray

    @classmethod
    def of_edges(
        cls,
        nodes: int,
        edges: Sequence[tuple[int, int, int]],
        pulls: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> "Traffic":
        """From (source node, target node, inner captured frames) of each edge; all frames are wanted alike unless
        ``pulls`` are given, ``node_pull`` and ``edge_pull``."""
        table = np.array(edges, np.int64).reshape(-1, 3)
        chain, inner = Chain(table[:, 0], table[:, 1], nodes), table[:, 2].astype(np.float64)
        frames = nodes + inner.sum()
        node_pull, edge_pull = pulls or (np.full(nodes, frames), frames * inner)
        return cls(chain, inner, np.bincount(table[:, 0], minlength=nodes), node_pull, edge_pull)

    @property
    def source(self) -> np.ndarray:
        return self.chain.source

    @property
    def frames(self) -> float:
        """n, the number of captured frames."""
        return float(self.chain.nodes + self.inner.sum())

    def visits(self, probabilities: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Share of a long walk's captured frames: (N,) at each node, and (E,) at each inner frame of each edge."""
        node = self.chain.solve(probabilities).visits
        edge = node[self.source] * probabilities
        total = node.sum() + self.inner @ edge
        return node / total, edge / total


def objective(traffic: Traffic, probabilities: np.ndarray, alpha: float) -> tuple[float, np.ndarray]:
    """P's energy and its exact gradient by the (E,) probabilities.

    ``alpha sum_f (S_f - w_f)^2 / w_f + (1 - alpha) |E| / N^2 |P|_F^2`` with S the share of each of the n captured
    frames in the captured frames of a long walk and w the share that is wanted, 1/n unless said otherwise: then the
    first term is P's ``alpha n |S(P) - 1/n|^2``. P sums over the contracted graph's N nodes in the first term too, but
    even visits to those say little about frames, as some edges hold hundreds. |P|_F sums over edges, as parallel ones
    stay apart. The second term, about 1 for even choices, keeps a single transition from doing all the work.
    """
    solved = traffic.chain.solve(probabilities)
    source, inner, pull = traffic.source, traffic.inner, traffic.node_pull
    node = solved.visits
    edge = node[source] * probabilities
    total = node.sum() + inner @ edge
    squares = node @ (pull * node) + traffic.edge_pull @ edge**2
    # sum (S - w)^2 / w = sum S^2 / w - 1, as S and w sum to one; with S = visits / total.
    uneven = squares / total**2 - 1
    by_squares, by_total = 1 / total**2, -2 * squares / total**3
    by_edge = 2 * by_squares * traffic.edge_pull * edge + inner * by_total
    by_node = (
        2 * by_squares * pull * node + by_total + np.bincount(source, by_edge * probabilities, traffic.chain.nodes)
    )
    gradient = node[source] * (by_edge + solved.adjoint(by_node)[traffic.chain.target])
    penalty, by_penalty = _choice_penalty(traffic, probabilities)
    return alpha * uneven + (1 - alpha) * penalty, alpha * gradient + (1 - alpha) * by_penalty


def proxy(traffic: Traffic, probabilities: np.ndarray, alpha: float) -> tuple[float, np.ndarray]:
    """P's convex stand-in, ``alpha n |pi P - pi|^2 + (1 - alpha) |E| / N^2 |P|_F^2``, and its gradient. All frames are
    wanted alike in it: it is there to start from.

    pi P spreads the uniform distribution by one choice: an edge's inner frames get p / n each, a node the sum over its
    in-edges.
    """
    frames, target = traffic.frames, traffic.chain.target
    node = np.bincount(target, probabilities, traffic.chain.nodes) - 1
    edge = probabilities - 1
    uneven = (node @ node + traffic.inner @ edge**2) / frames
    gradient = 2 * (node[target] + traffic.inner * edge) / frames
    penalty, by_penalty = _choice_penalty(traffic, probabilities)
    return alpha * uneven + (1 - alpha) * penalty, alpha * gradient + (1 - alpha) * by_penalty


def even_probabilities(traffic: Traffic) -> np.ndarray:
    """(E,) the same probability for each of a node's out-edges."""
    return 1.0 / traffic.ways[traffic.source]


def optimise_probabilities(traffic: Traffic, options: GraphOptions) -> np.ndarray:
    """(E,) probabilities that minimise ``objective``, each at least ``options.least_share`` of an even choice.

    L-BFGS on ``p = floor + (1 - least_share) softmax(q)``, from the minimum of ``proxy`` and from even choices; the
    better end counts. The chain must be irreducible.
    """
    even = even_probabilities(traffic)
    ends = [
        _minimise(traffic, options.least_share, start, lambda p: objective(traffic, p, options.alpha))
        for start in (proxy_minimum(traffic, options), even)
    ]
    return min(ends, key=lambda p: objective(traffic, p, options.alpha)[0])


def proxy_minimum(traffic: Traffic, options: GraphOptions) -> np.ndarray:
    """(E,) probabilities that minimise ``proxy``, with the same floor: where P's search begins."""
    even = even_probabilities(traffic)
    return _minimise(traffic, options.least_share, even, lambda p: proxy(traffic, p, options.alpha))


def thresholds(source: np.ndarray, probabilities: np.ndarray) -> np.ndarray:
    """(E,) uint32: per node, the cumulative probability times 2^32, less one; the last out-edge has 2^32 - 1.

    A number r from 0 to 2^32 - 1 goes to the first out-edge, in order, with ``r <= threshold``. ``source`` ascends.
    """
    limits = np.zeros(len(source), np.uint32)
    first = 0
    for edge, node in enumerate(source):
        if source[first] != node:
            first = edge
        if edge + 1 == len(source) or source[edge + 1] != node:
            limits[edge] = 0xFFFFFFFF
        else:
            reached = round(float(probabilities[first : edge + 1].sum()) * 2**32) - 1
            limits[edge] = min(max(reached, 0), 0xFFFFFFFF)
    return limits


def _choice_penalty(traffic: Traffic, probabilities: np.ndarray) -> tuple[float, np.ndarray]:
    scale = len(probabilities) / traffic.chain.nodes**2
    return float(scale * (probabilities @ probabilities)), 2 * scale * probabilities


def _minimise(traffic: Traffic, least_share: float, start: np.ndarray, energy: Objective) -> np.ndarray:
    source, nodes, even = traffic.source, traffic.chain.nodes, even_probabilities(traffic)
    free = 1 - least_share
    if free == 0 or np.all(traffic.ways <= 1):
        return even
    first = np.searchsorted(source, np.arange(nodes))  # edges are ordered by source and every node has one

    def softmax(logits: np.ndarray) -> np.ndarray:
        weights = np.exp(logits - np.maximum.reduceat(logits, first)[source])
        return weights / np.bincount(source, weights, nodes)[source]

    def by_logits(logits: np.ndarray) -> tuple[float, np.ndarray]:
        share = softmax(logits)
        value, gradient = energy(least_share * even + free * share)
        mean = np.bincount(source, share * gradient, nodes)
        return value, free * share * (gradient - mean[source])

    # A start on its floor would have an infinite logit and no way back.
    logits = np.log(np.maximum((start - least_share * even) / free, 1e-3 * even))
    found = minimize(
        by_logits, logits, jac=True, method="L-BFGS-B", options={"maxiter": 500, "gtol": 1e-9, "ftol": 1e-13}
    )
    return least_share * even + free * softmax(found.x)
