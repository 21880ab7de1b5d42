"""What tracking hands to synthesis."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class TrackedPair:
    """One template surface and tet cage, fitted to every frame of two windows.

    All positions are in the frames' own captured places (metres, z up, floor 0): the target window is *not* moved to
    the source. Frame order: the source window s-k .. s+k, then the target window t-k .. t+k; windows of a ``warp`` may
    have more or fewer frames.

    Attributes
    ----------
    source, target : frame indices s and t
    k : half window
    frames : (4k+2,) int32 frame indices
    template : index into ``frames`` of the frame the template was taken from
    vertices : (4k+2, n, 3) float64 tracked surface vertices
    faces : (m, 3) int32
    uv, face_uv, face_material : the template frame's atlas, as in TexturedMesh
    cage_vertices : (4k+2, c, 3) float64
    tets : (q, 4) int32, positively oriented at the template frame
    tet_of_vertex : (n,) int32 the cage cell that carries each surface vertex
    weights : (n, 4) float64 barycentric weights in that cell (sum 1; negative where the vertex lies outside it)
    residual : (4k+2, n, 3) float64 surface minus embedding, in the rotation frame of the carrying tet
    yaw : the candidate's yaw (radians), target onto source
    measures : numbers for the quality card (hausdorff_m and others), each (4k+2,) float64
    warp : (2, 2k+1) int32 positions in ``frames``: of the source's and of the target's frame that are blended at each
        step; None where both windows are played frame by frame
    """

    source: int
    target: int
    k: int
    frames: np.ndarray
    template: int
    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    face_uv: np.ndarray
    face_material: np.ndarray | None
    cage_vertices: np.ndarray
    tets: np.ndarray
    tet_of_vertex: np.ndarray
    weights: np.ndarray
    residual: np.ndarray
    yaw: float
    measures: dict[str, np.ndarray]
    warp: np.ndarray | None = None

    @property
    def steps(self) -> np.ndarray:
        """(2, 2k+1) positions in ``frames`` of what is blended at each step -k .. k."""
        if self.warp is not None:
            return self.warp
        return np.arange(4 * self.k + 2).reshape(2, -1)

    @property
    def windows(self) -> tuple[slice, slice]:
        """The source's and the target's frames among all."""
        split = int(self.steps[1, 0])
        return slice(0, split), slice(split, len(self.frames))
