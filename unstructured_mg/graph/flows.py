"""Transition probabilities as a convex programme in edge flows."""

from collections.abc import Callable

import numpy as np

from unstructured_mg.graph.options import GraphOptions
from unstructured_mg.graph.probabilities import Traffic, even_probabilities

# The gap to the minimum (in units of the energy, which is about 1) at which the interior-point method stops, and by
# what its weight falls from one round to the next.
GAP, SHRINK = 1e-10, 0.1
NEWTON_STEPS = 60


def entropy_rate(traffic: Traffic, probabilities: np.ndarray) -> float:
    """Nats of choice for every captured frame that a long walk shows."""
    _, edge = traffic.visits(probabilities)
    return float(-edge @ np.log(probabilities, where=probabilities > 0, out=np.zeros_like(probabilities)))


def flow_energy(
    traffic: Traffic, flows: np.ndarray, alpha: float, even_entropy: float
) -> tuple[float, np.ndarray, np.ndarray]:
    """The energy of (E,) flows with its (E,) gradient and (E, E) Hessian.

    x_e is how often edge e is taken for every captured frame shown, v_i the sum of x over the edges out of node i. With
    w the wanted shares of the captured frames, each visited as often as its node or edge,

        alpha sum_f (v_f - w_f)^2 / w_f - (1 - alpha) H / H_even,  H = - sum_e x_e log(x_e / v_source(e)),

    the entropy rate H in units of that of even choices. Both terms are convex in x (P's second one is not), and what
    makes x a walk is linear: as much flows into every node as out of it, and all captured frames together have share 1.
    """
    source, nodes = traffic.source, traffic.chain.nodes
    leaving = np.bincount(source, flows, nodes)
    choice = np.log(flows / leaving[source])
    scale = (1 - alpha) / even_entropy
    value = alpha * (leaving @ (traffic.node_pull * leaving) + traffic.edge_pull @ flows**2 - 1) + scale * (
        flows @ choice
    )
    gradient = 2 * alpha * ((traffic.node_pull * leaving)[source] + traffic.edge_pull * flows) + scale * choice
    same = source[:, None] == source
    hessian = same * (2 * alpha * traffic.node_pull - scale / leaving)[source]
    hessian[np.diag_indices(len(flows))] += 2 * alpha * traffic.edge_pull + scale / flows
    return float(value), gradient, hessian


def optimise_flows(traffic: Traffic, options: GraphOptions) -> np.ndarray:
    """(E,) probabilities whose flows minimise ``flow_energy``, each at least ``least_share`` of an even choice.

    The floors, x_e >= least_share / ways v_source(e), are linear in x too, so this is one convex programme with one
    answer. It is found by Newton's method on the energy with logarithmic barriers before the floors, whose weight falls
    until what they can hide is below 1e-10.
    """
    even = even_probabilities(traffic)
    if options.least_share == 1 or np.all(traffic.ways <= 1):
        return even
    source, target, nodes = traffic.source, traffic.chain.target, traffic.chain.nodes
    count = len(source)
    index = np.arange(count)
    balance = np.zeros((nodes, count))
    np.add.at(balance, (source, index), 1.0)
    np.add.at(balance, (target, index), -1.0)
    shown = 1 + traffic.inner  # captured frames that an edge shows, with the node that it leaves
    equal = np.vstack([balance[1:], shown])  # one node's balance follows from the others'
    # Where a node has one way there is nothing to choose, and no floor to keep from.
    free = np.flatnonzero(traffic.ways[source] > 1)
    floors = np.eye(count)[free] - (options.least_share * even[free])[:, None] * (source[free][:, None] == source)

    node, edge = traffic.visits(even)
    flows = edge.copy()
    weight, entropy = 1e-2, entropy_rate(traffic, even)
    while True:
        for _ in range(NEWTON_STEPS):
            _, gradient, hessian = flow_energy(traffic, flows, options.alpha, entropy)
            room = floors @ flows
            gradient = gradient - weight * (floors.T @ (1 / room))
            hessian = hessian + weight * (floors.T * (1 / room**2)) @ floors
            step = _newton_step(hessian, gradient, equal, flows)
            decrement = float(-gradient @ step)
            if decrement < 1e-3 * min(weight, GAP * 1e3) * len(free):
                break
            flows = _move(
                lambda x: flow_energy(traffic, x, options.alpha, entropy)[0], flows, step, floors, weight, decrement
            )
        if weight * len(free) < GAP:
            break
        weight *= SHRINK
    return np.asarray(flows / np.bincount(source, flows, nodes)[source])


def _newton_step(hessian: np.ndarray, gradient: np.ndarray, equal: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The step that minimises the quadratic model and keeps the ``equal`` sums; solved in shares of ``scale``."""
    count, rows = len(hessian), len(equal)
    matrix = np.zeros((count + rows, count + rows))
    matrix[:count, :count] = hessian * scale * scale[:, None]
    scaled = equal * scale
    scaled /= np.linalg.norm(scaled, axis=1)[:, None]
    matrix[count:, :count], matrix[:count, count:] = scaled, scaled.T
    # What has no choice has no curvature: only the sums hold it, which leaves the matrix regular.
    solved = np.linalg.solve(matrix, np.concatenate([-gradient * scale, np.zeros(rows)]))
    return np.asarray(solved[:count] * scale)


def _move(
    energy: Callable[[np.ndarray], float],
    flows: np.ndarray,
    step: np.ndarray,
    floors: np.ndarray,
    weight: float,
    decrement: float,
) -> np.ndarray:
    """As far along the step as stays inside and pays."""
    room, change = floors @ flows, floors @ step
    length = 1.0
    for bound, rate in ((room, change), (flows, step)):
        falling = rate < 0
        if falling.any():
            length = min(length, 0.99 * float((bound[falling] / -rate[falling]).min()))

    def barrier(moved: np.ndarray) -> float:
        return energy(moved) - weight * float(np.log(floors @ moved).sum())

    now = barrier(flows)
    for _ in range(40):
        if barrier(flows + length * step) <= now - 1e-4 * length * decrement:
            return flows + length * step
        length /= 2
    return flows
