"""The pose metric of B section 3.1, for captures with one connectivity: how far triangles are turned and stretched."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from unstructured_mg import _native
from unstructured_mg.capture.capture import Capture
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.laplacian import face_areas
from unstructured_mg.geometry.morton import morton_order
from unstructured_mg.matching.descriptor import Descriptor, Window
from unstructured_mg.matching.fields import Fields

# Triangles that stand for all: a multiple of the 16 lanes of the kernel.
TRIANGLES = 1024
# w_m of B equation 3.
STRETCH = 0.01
# Rows of a frame's description: turn (quaternion x, y, z, w) and edges of the triangles; their centres on the floor.
POSE, CENTRE, ROWS = range(7), range(7, 9), 9


@dataclass(frozen=True)
class Triangles:
    """The faces of every frame, the sampled ones among them, and the weights (total 1) of these for the alignment."""

    faces: np.ndarray
    sampled: np.ndarray
    weights: np.ndarray


def fit(capture: Capture, extents: np.ndarray, resolution: int | None = None, colour: float = 0.0) -> Triangles:
    """Sample the first frame's triangles evenly along a space-filling curve: a mean over them is one over all."""
    mesh = capture.read(0)
    order = morton_order(mesh.vertices[mesh.faces].sum(axis=1))
    sampled = order[np.arange(TRIANGLES) * len(order) // TRIANGLES]
    areas = face_areas(mesh.vertices, mesh.faces[sampled])
    return Triangles(mesh.faces, sampled, areas / areas.sum())


def shape(layout: Triangles) -> tuple[int, int, type]:
    return ROWS, TRIANGLES, np.float32


def describe(capture: Capture, index: int, extent: np.ndarray, layout: Triangles) -> tuple[np.ndarray, float]:
    """Every sampled triangle's frame and shape: what B equation 1 needs of one frame.

    A UserError where the frame's connectivity is not the first one's.
    """
    mesh = capture.read(index)
    if not np.array_equal(mesh.faces, layout.faces):
        raise UserError(
            f"{capture.frames[index].path}: has another connectivity than {capture.frames[0].path.name}, and "
            "deformation gradients need one for all frames; choose another descriptor (--descriptor cylindrical_edt)."
        )
    values = np.empty((ROWS, TRIANGLES), np.float32)
    corners = mesh.vertices[mesh.faces[layout.sampled]]
    values[list(POSE)] = triangle_poses(corners)
    centres = corners[:, :, :2].mean(axis=1)
    values[list(CENTRE)] = (centres - layout.weights @ centres).T
    return values, 0.0


def triangle_poses(corners: np.ndarray) -> np.ndarray:
    """``(7, m)`` of triangles (m, 3, 3): the turn q from axes x, y, z to first edge, across it, normal; and a, b, c.

    v_1 - v_3 = q (a, 0, 0) and v_2 - v_3 = q (b, c, 0), so that equation 1 from pose i to pose j is
    T = q_j [a' b' 0; 0 c' 0; 0 0 1] [a b 0; 0 c 0; 0 0 1]^-1 q_i^T on column vectors. (B prints it for rows and
    factors T = R S as for columns; the transpose has the same angle and the same stretches.)
    """
    first, second = corners[:, 0] - corners[:, 2], corners[:, 1] - corners[:, 2]
    normal = np.cross(first, second)
    a, twice = np.linalg.norm(first, axis=1), np.linalg.norm(normal, axis=1)
    # Triangles without an area have no frame: they get one, and are few.
    flat = twice <= 1e-12
    first[flat], normal[flat] = [1e-6, 0, 0], [0, 0, 1]
    a[flat], twice[flat] = 1e-6, 1.0
    along, normal = first / a[:, None], normal / twice[:, None]
    across = np.cross(normal, along)
    turn = Rotation.from_matrix(np.stack([along, across, normal], axis=2)).as_quat()
    b, c = np.einsum("mi,mi->m", second, along), np.einsum("mi,mi->m", second, across)
    c[flat] = 1e-6
    return np.concatenate([turn.T, [a, b, c]])


def compare(
    fields: Fields, layout: Triangles, own: np.ndarray, rows: range, columns: range, windows: Sequence[Window]
) -> list[tuple[np.ndarray, np.ndarray]]:
    """``Descriptor.compare``: the yaw aligns the windows' triangles by least squares, then poses are compared.

    d = 1/M sum_m (1/sqrt 2 |log R_m|_F + w_m |S_m - I|_F) (B equation 3, its sum as a mean over triangles, and
    |S - I| the mean of both ways, which differ), in radians; a window's score is the root of the weighted mean of its
    frames' squares.
    """
    k = max(window.k for window in windows)
    frames = [rows] if rows == columns else [rows, columns]
    poses = [np.stack([fields.read(row, r.start - k, r.stop + k) for row in POSE]) for r in frames]
    places = [
        (fields.read(CENTRE[0], r.start - k, r.stop + k) + 1j * fields.read(CENTRE[1], r.start - k, r.stop + k))
        for r in frames
    ]
    weighted = (places[0] * layout.weights).astype(np.complex64)
    # Minimising sum |z_s - e^(i yaw) z_t|^2 over a window maximises Re e^(-i yaw) sum z_s conj(z_t).
    products = weighted @ places[-1].conj().astype(np.complex64).T
    found = []
    for window in windows:
        inner = slice(k - window.k, window.k - k or None)
        sums = np.empty((len(rows), len(columns)), np.complex64)
        values = np.ascontiguousarray(products[inner, inner]).view(np.float32)
        weights = window.weights.astype(np.float32)
        _native.window_diagonals(values, weights, sums.view(np.float32), *sums.shape)
        yaw = np.angle(sums).astype(np.float64)
        squares = np.zeros_like(yaw)
        own_poses, other_poses = (np.ascontiguousarray(each[:, inner]) for each in (poses[0], poses[-1]))
        _native.pose_distances(own_poses, other_poses, yaw, window.weights, squares, STRETCH, rows == columns)
        across, along = window.velocity[rows.start : rows.stop, None], window.velocity[columns.start : columns.stop]
        squares += np.abs(across - np.exp(1j * yaw) * along) ** 2
        found.append((squares, yaw))
    return found


# The threshold lets pairs through that are about as different as those at the threshold of the cylindrical grid: scores
# of the two are 0.52 and 4 % of the size together on the registered crane capture.
DESCRIPTOR = Descriptor("rad", 0.5, None, False, fit, shape, describe, compare)
