"""Partial paths that end at the same node, with where each of them has led on the floor: arrays, one row a path."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.geometry.planar import PlanarRigid

# Partial paths that end closer than this at the same node, heading the same way, go on alike.
CELL_METRES, CELL_RADIANS = 0.01, 0.01


@dataclass(frozen=True)
class Labels:
    """m partial paths.

    Attributes
    ----------
    pose : (m, 3) float64 yaw, x, y: the last frame's captured place to the world
    worth : (m, w) float64 what has been paid, compared column by column, less is better
    frames : (m,) int64 played after the start
    parent : (m,) int64 position in the trail of the partial path that each goes on from
    arc : (m,) int64 the arc that it went on by
    """

    pose: np.ndarray
    worth: np.ndarray
    frames: np.ndarray
    parent: np.ndarray
    arc: np.ndarray

    def __len__(self) -> int:
        return len(self.pose)

    def take(self, rows: np.ndarray) -> "Labels":
        return Labels(self.pose[rows], self.worth[rows], self.frames[rows], self.parent[rows], self.arc[rows])


def join_labels(parts: list[Labels]) -> Labels:
    """All rows, in order."""
    return Labels(
        *(np.concatenate([getattr(p, name) for p in parts]) for name in ("pose", "worth", "frames", "parent", "arc"))
    )


def best_labels(labels: Labels, rank: np.ndarray, group: np.ndarray, width: int) -> np.ndarray:
    """Rows of the ``width`` best by ``rank`` (m, r), best first, of which no two end in one cell of floor and heading
    and in one ``group`` (m,) int. Equal ranks go by order."""
    order = np.lexsort([*rank.T[::-1]])
    cells = np.column_stack(
        [np.rint(labels.pose[:, 0] / CELL_RADIANS), np.rint(labels.pose[:, 1:] / CELL_METRES), group]
    ).astype(np.int64)[order]
    _, first = np.unique(cells, axis=0, return_index=True)
    return order[np.sort(first)][:width]


class Trail:
    """How every partial path came about."""

    def __init__(self) -> None:
        self._parent: list[np.ndarray] = []
        self._arc: list[np.ndarray] = []
        self._first: list[int] = [0]

    def add(self, labels: Labels) -> np.ndarray:
        """The labels' positions, (m,) int64."""
        self._parent.append(labels.parent)
        self._arc.append(labels.arc)
        self._first.append(self._first[-1] + len(labels))
        return np.arange(self._first[-2], self._first[-1])

    def arcs(self, parent: int, arc: int) -> list[int]:
        """The arcs that lead to a label, in the order in which they are played."""
        found = [arc]
        while parent >= 0:
            part = int(np.searchsorted(self._first, parent, side="right")) - 1
            place = parent - self._first[part]
            arc, parent = int(self._arc[part][place]), int(self._parent[part][place])
            found.append(arc)
        return [arc for arc in found[::-1] if arc >= 0]


def start_labels(poses: np.ndarray, worth: int) -> Labels:
    """Paths without any arc yet, from ``poses`` (m, 3)."""
    nothing = np.full(len(poses), -1, np.int64)
    return Labels(poses, np.zeros((len(poses), worth)), np.zeros(len(poses), np.int64), nothing, nothing)


def placed(pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(m, f, 2): points (f, 2) moved by each of the poses (m, 3)."""
    c, s = np.cos(pose[:, :1]), np.sin(pose[:, :1])
    x, y = points[:, 0], points[:, 1]
    return np.stack([c * x - s * y + pose[:, 1:2], s * x + c * y + pose[:, 2:3]], axis=2)


def poses_after(pose: np.ndarray, motion: PlanarRigid) -> np.ndarray:
    """(m, 3): each pose times ``motion``, yaw in (-pi, pi]."""
    c, s = np.cos(pose[:, 0]), np.sin(pose[:, 0])
    yaw = np.pi - (np.pi - pose[:, 0] - motion.yaw) % (2 * np.pi)
    return np.column_stack([yaw, pose[:, 1] + c * motion.x - s * motion.y, pose[:, 2] + s * motion.x + c * motion.y])
