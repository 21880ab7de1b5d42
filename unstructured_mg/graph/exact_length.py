"""Paths of an exact number of frames, by dynamic programming over (frames left, node)."""

import numpy as np

from unstructured_mg.graph.routes import Routes


class LengthTable:
    """The least cost from every node to the goal in exactly so many frames.

    cost[t, v] = min over arcs (v, w) of cost(arc) + cost[t - frames(arc), w], cost[0, goal] = 0. Rows are made when
    they are asked for. Without a goal a path may end inside an arc, and the arc's cost is paid where it begins.
    """

    def __init__(self, routes: Routes) -> None:
        self.routes = routes
        self._source = np.array([arc.source for arc in routes.arcs], np.int64)
        self._target = np.array([arc.target for arc in routes.arcs], np.int64)
        self._frames = np.array([arc.frames for arc in routes.arcs], np.int64)
        self._costs = np.array([arc.cost for arc in routes.arcs], np.float64)
        # A row for 0 frames, and impossible ones before it that every arc may reach back to.
        self._before = int(self._frames.max(initial=1))
        self._rows = np.full((self._before + 1, len(routes.frames)), np.inf)
        if routes.goal is None:
            self._rows[:] = 0  # a path that has no frame left may be anywhere on an arc
        else:
            self._rows[self._before, routes.goal] = 0
        self._made = 1

    def upto(self, frames: int) -> np.ndarray:
        """(frames + 1, nodes) float64: row t holds the least costs of t frames; inf where there is no way."""
        if frames >= self._made:
            grown = np.full((self._before + max(frames + 1, 2 * self._made), self._rows.shape[1]), np.inf)
            grown[: self._before + self._made] = self._rows[: self._before + self._made]
            self._rows = grown
            if len(self._source):
                starts = np.flatnonzero(np.r_[True, np.diff(self._source) > 0])
                heads = self._source[starts]
                for t in range(self._made, frames + 1):
                    after = self._rows[t + self._before - self._frames, self._target]
                    self._rows[t + self._before, heads] = np.minimum.reduceat(self._costs + after, starts)
            self._made = frames + 1
        return self._rows[self._before : self._before + frames + 1]

    def possible(self, node: int, frames: int, least: int = 0) -> int | None:
        """The length nearest to ``frames``, and no less than ``least``, for which there is a way from ``node``; of two
        equally near ones the shorter. None where no way leads to the goal at all."""
        horizon = max(frames, least, self._before) + len(self.routes.frames) * self._before
        reach = frames
        while True:
            found = np.flatnonzero(np.isfinite(self.upto(reach)[least:, node])) + least
            if len(found):
                nearest = int(found[np.argmin(np.abs(found - frames))])
                # Longer ones may be nearer than this.
                if nearest >= frames or reach >= 2 * frames - nearest - 1:
                    return nearest
                reach = 2 * frames - nearest - 1
            elif reach >= horizon:
                return None
            else:
                reach = min(horizon, max(2 * reach, reach + self._before))

    def trace(self, node: int, frames: int) -> list[int]:
        """The arcs of a least-cost way of ``frames`` frames from ``node``; of equal ones those with lower indices."""
        costs, arcs = self.upto(frames), self.routes.arcs
        padded = self._rows
        chosen: list[int] = []
        while frames > 0:
            best = min(
                self.routes.out[node],
                key=lambda index: (
                    arcs[index].cost + padded[frames + self._before - arcs[index].frames, arcs[index].target]
                ),
            )
            if not np.isfinite(costs[frames, node]):
                raise ValueError(f"frames: expected a possible length from node {node}, got {frames}")
            chosen.append(best)
            frames -= arcs[best].frames
            node = arcs[best].target
        return chosen
