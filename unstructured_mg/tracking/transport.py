"""Soft one-to-one correspondence of two sampled surfaces by entropic optimal transport (Cuturi 2013)."""

import numpy as np

_SMALLEST = 1e-300


class Transport:
    """Plans P minimising sum P_ij C_ij + blur^2 KL(P | a b) with marginals a and b, for a source that moves.

    C_ij = |x_i - y_j|^2 + turn^2 |n_i - m_j|^2. Nearest points may all choose the same limb; a plan must use
    every part of the target once: a lifted leg is not drawn to the standing one. The dual factors are kept from plan
    to plan, so few rounds are enough. Sums are einsum's, not BLAS's, whose bits depend on its threads.
    """

    def __init__(
        self, shares: np.ndarray, goals: np.ndarray, goal_normals: np.ndarray, goal_shares: np.ndarray, turn: float
    ):
        self._shares, self._goals, self._goal_normals = shares, goals, goal_normals
        self._goal_shares, self._turn = goal_shares, turn
        self._there = np.ones(len(goals))

    def mean_goals(
        self, points: np.ndarray, normals: np.ndarray, blur: float, rounds: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """For points (p, 3) with unit normals: the mean (p, 3) of what each is sent to, and the mass (p,) it sends."""
        cost = (points**2).sum(1)[:, None] + (self._goals**2).sum(1) - 2 * np.einsum("ix,jx->ij", points, self._goals)
        cost += 2 * self._turn**2 * (1 - np.einsum("ix,jx->ij", normals, self._goal_normals))
        kernel = np.exp(-np.maximum(cost, 0) / blur**2)
        there = self._there
        here = np.ones(len(points))
        for _ in range(rounds):
            here = 1 / np.maximum(np.einsum("ij,j->i", kernel, self._goal_shares * there), _SMALLEST)
            there = 1 / np.maximum(np.einsum("ij,i->j", kernel, self._shares * here), _SMALLEST)
        self._there = there
        sent = kernel * (self._goal_shares * there)
        mass = sent.sum(1)
        means = np.einsum("ij,jx->ix", sent, self._goals) / np.maximum(mass, _SMALLEST)[:, None]
        return means, self._shares * here * mass
