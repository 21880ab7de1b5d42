"""A capture in memory: a bending body that is meshed anew in every frame."""

from dataclasses import dataclass

import numpy as np
from tracking.bodies import bend, figure

from unstructured_mg.capture.mesh import TexturedMesh


@dataclass(frozen=True)
class BendingCapture:
    """Frame i is the standing body, bent by ``angles[i]``, moved by ``places[i]`` and turned by ``yaws[i]``.

    Every frame has a connectivity of its own and, as debris, a floating tetrahedron.
    """

    angles: np.ndarray
    places: np.ndarray
    yaws: np.ndarray

    def __len__(self) -> int:
        return len(self.angles)

    def frame_id(self, index: int) -> str:
        return str(index)

    def pose(self, index: int, points: np.ndarray) -> np.ndarray:
        c, s = np.cos(self.yaws[index]), np.sin(self.yaws[index])
        return bend(points, self.angles[index]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T + self.places[index]

    def rest(self, index: int) -> tuple[np.ndarray, np.ndarray]:
        return figure(36 + index % 5, 50 + index % 7)

    def read(self, index: int) -> TexturedMesh:
        vertices, faces = self.rest(index)
        debris = np.array([[1, 1, 1], [1.01, 1, 1], [1, 1.01, 1], [1, 1, 1.01]]) * [1.0, 1.0, 1.5]
        debris_faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32) + len(vertices)
        return TexturedMesh(
            np.concatenate([self.pose(index, vertices), debris]), np.concatenate([faces, debris_faces]).astype(np.int32)
        )


def swaying(frames: int) -> BendingCapture:
    """Two like bows far apart in time, the second at another place and facing another way."""
    half = frames // 2
    angles = 0.25 + 0.15 * np.sin(0.25 * np.concatenate([np.arange(half), np.arange(frames - half)]))
    second = np.arange(frames) >= half
    places = np.where(second[:, None], [0.6, -0.4, 0.0], [0.0, 0.0, 0.0])
    return BendingCapture(angles, places, np.where(second, 0.9, 0.0))
