"""Normal equations on a cage: fixed sparsity, assembled by 3x3 blocks, solved by Cholesky factors."""

import numpy as np

from unstructured_mg import _native
from unstructured_mg.geometry.rotations import fit_rotations
from unstructured_mg.geometry.tets import deformation_gradients, tet_gradients, tet_volumes
from unstructured_mg.tracking.block_cholesky import BlockCholesky

_PAIRS = np.array([[0, 0], [1, 1], [2, 2], [3, 3], [0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])


class CageSystem:
    """Quadratic models of ``strength * E_ARAP + point-to-plane data`` in the cage's vertices (c, 3).

    The ARAP energy of P A.2, sum |tet| min_R |F - R|^2, is linearised with its rotations free to follow (Gauss-Newton
    of F - R(F)); its matrix is the corotated linear elasticity |tet| (g_i.g_j I + R g_j (R g_i)^T).
    """

    def __init__(self, rest: np.ndarray, tets: np.ndarray):
        self.tets = np.ascontiguousarray(tets, np.int32)
        self.gradients = np.ascontiguousarray(tet_gradients(rest, tets))
        self.volumes = np.abs(tet_volumes(rest, tets))
        count = len(rest)
        rows, columns = tets[:, _PAIRS[:, 0]].ravel(), tets[:, _PAIRS[:, 1]].ravel()
        low, high = np.minimum(rows, columns), np.maximum(rows, columns)
        unique, block = np.unique(high.astype(np.int64) * count + low, return_inverse=True)
        self.block = np.ascontiguousarray(block.reshape(-1, 10), np.int32)
        # A block is stored as (higher, lower) vertex; a tet's pair (i, j) is flipped where i is the lower.
        self.flip = np.ascontiguousarray((rows < columns).reshape(-1, 10), np.uint8)
        self.block_count = len(unique)
        self._solver = BlockCholesky(count, np.stack([unique // count, unique % count], axis=1))
        self.count = count

    @classmethod
    def like(cls, other: "CageSystem", rest: np.ndarray) -> "CageSystem":
        """The same cage with other rest positions (c, 3); ordering and storage are shared."""
        made = cls.__new__(cls)
        made.__dict__.update(other.__dict__)
        made.gradients = np.ascontiguousarray(tet_gradients(rest, other.tets))
        made.volumes = np.abs(tet_volumes(rest, other.tets))
        return made

    def rotations(self, vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Deformation gradients F (q, 3, 3) and their nearest rotations."""
        linear = deformation_gradients(vertices, self.tets, self.gradients)
        return linear, fit_rotations(linear)

    def scatter(self, corners: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Sum values (p, 4, 3) at the cage vertices corners (p, 4)."""
        flat = corners.ravel()
        return np.stack([np.bincount(flat, values[..., a].ravel(), minlength=self.count) for a in range(3)], axis=1)

    def new_terms(self) -> tuple[np.ndarray, np.ndarray]:
        """Blocks (b, 9) and a right side (c, 3) to add to."""
        return np.zeros((self.block_count, 9)), np.zeros((self.count, 3))

    def add_arap(self, blocks: np.ndarray, right: np.ndarray, vertices: np.ndarray, strength: np.ndarray) -> None:
        """Add the ARAP energy at ``vertices`` (c, 3): half its Gauss-Newton Hessian and minus half its gradient.

        Every tet counts times its ``strength`` (q,).
        """
        _native.arap_terms(
            strength * self.volumes, self.gradients, np.ascontiguousarray(vertices), self.tets, self.block, self.flip,
            blocks, right,
        )  # fmt: skip

    def add_planes(
        self,
        blocks: np.ndarray,
        right: np.ndarray,
        tet: np.ndarray,
        weights: np.ndarray,
        planes: np.ndarray,
        strength: np.ndarray,
        offsets: np.ndarray,
    ) -> None:
        """Add sum_p strength_p (n_p . sum_i w_pi step_i - offset_p)^2 for points in tets (p,) int32, weights (p, 4)."""
        _native.plane_terms(tet, weights, planes, strength, offsets, self.tets, self.block, blocks, right)

    def solve(self, blocks: np.ndarray, right: np.ndarray, damping: float) -> np.ndarray:
        """The step (c, 3) with (matrix + damping I) step = right (c, 3)."""
        return self._solver.solve(blocks, right, damping)
