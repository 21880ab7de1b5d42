"""The procedural figure's bones: rest joints, forward kinematics and two-bone legs.

Metres, z up, floor at 0. At rest the figure faces -y, its left side is at +x, and its arms and legs are spread so that
no two parts touch. All joint frames are parallel to the world's axes at rest.
"""

import numpy as np

JOINTS: dict[str, tuple[str | None, tuple[float, float, float]]] = {
    "pelvis": (None, (0.0, 0.0, 0.96)),
    "spine": ("pelvis", (0.0, 0.0, 1.06)),
    "chest": ("spine", (0.0, 0.005, 1.21)),
    "neck": ("chest", (0.0, 0.018, 1.44)),
    "head": ("neck", (0.0, 0.006, 1.535)),
}
for _side, _sign in (("left", 1.0), ("right", -1.0)):
    JOINTS |= {
        f"{_side}_clavicle": ("chest", (_sign * 0.035, 0.008, 1.395)),
        f"{_side}_shoulder": (f"{_side}_clavicle", (_sign * 0.178, 0.010, 1.395)),
        f"{_side}_elbow": (f"{_side}_shoulder", (_sign * 0.378, 0.012, 1.215)),
        f"{_side}_wrist": (f"{_side}_elbow", (_sign * 0.548, -0.016, 1.046)),
        f"{_side}_hip": ("pelvis", (_sign * 0.092, 0.0, 0.925)),
        f"{_side}_knee": (f"{_side}_hip", (_sign * 0.118, -0.014, 0.512)),
        f"{_side}_ankle": (f"{_side}_knee", (_sign * 0.140, 0.016, 0.092)),
        f"{_side}_toe": (f"{_side}_ankle", (_sign * 0.150, -0.118, 0.024)),
    }

NAMES = tuple(JOINTS)
INDEX = {name: i for i, name in enumerate(NAMES)}
PARENT = tuple(-1 if parent is None else INDEX[parent] for parent, _ in JOINTS.values())
REST = np.array([position for _, position in JOINTS.values()])


def rotation(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotations (..., 3, 3) by ``angle`` (...,) radians about the unit vectors ``axis`` (..., 3), right-handed."""
    axis, angle = np.broadcast_arrays(np.asarray(axis, float), np.asarray(angle, float)[..., None])
    angle = angle[..., 0]
    x, y, z = np.moveaxis(axis, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([np.stack(row, -1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))], -2)
    outer = axis[..., :, None] * axis[..., None, :]
    c, s = np.cos(angle)[..., None, None], np.sin(angle)[..., None, None]
    return c * np.eye(3) + s * cross + (1 - c) * outer


def swing(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """The smallest rotations (..., 3, 3) that carry unit vectors ``start`` to ``end`` (..., 3); never opposite."""
    v, c = np.cross(start, end), np.sum(start * end, -1)[..., None, None]
    x, y, z = np.moveaxis(v, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([np.stack(row, -1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))], -2)
    return np.eye(3) + cross + cross @ cross / (1 + c)


def unit(vectors: np.ndarray) -> np.ndarray:
    """``vectors`` (..., 3) divided by their lengths."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def chain(local: dict[str, np.ndarray], root: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World rotations (frames, joints, 3, 3) and joint positions (frames, joints, 3).

    ``local`` gives a joint's rotation (frames, 3, 3) against its parent (absent: none), ``root`` (frames, 3) the
    pelvis's place.
    """
    frames = len(root)
    rotations = np.empty((frames, len(NAMES), 3, 3))
    positions = np.empty((frames, len(NAMES), 3))
    for joint, (name, parent) in enumerate(zip(NAMES, PARENT, strict=True)):
        own = local.get(name, np.broadcast_to(np.eye(3), (frames, 3, 3)))
        if parent < 0:
            rotations[:, joint], positions[:, joint] = own, root
        else:
            rotations[:, joint] = rotations[:, parent] @ own
            positions[:, joint] = positions[:, parent] + rotations[:, parent] @ (REST[joint] - REST[parent])
    return rotations, positions


def place_leg(
    rotations: np.ndarray,
    positions: np.ndarray,
    side: str,
    ankle: np.ndarray,
    foot: np.ndarray,
    toes: np.ndarray,
    pole: np.ndarray,
) -> None:
    """Bend one leg, in place, so that its ankle is at ``ankle`` (frames, 3).

    ``foot`` and ``toes`` (frames, 3, 3) are their rotations. ``pole`` (frames, 3) is where the knee points to. The hip
    keeps its place; where the ankle is out of reach the leg is stretched in its direction only as far as it goes.
    """
    hip, knee, end, toe = (INDEX[f"{side}_{part}"] for part in ("hip", "knee", "ankle", "toe"))
    thigh, shin = np.linalg.norm(REST[knee] - REST[hip]), np.linalg.norm(REST[end] - REST[knee])
    start = positions[:, hip]
    reach = ankle - start
    length = np.minimum(np.linalg.norm(reach, axis=1), 0.99999 * (thigh + shin))
    axis = unit(reach)
    side_way = unit(pole - axis * np.sum(pole * axis, 1, keepdims=True))
    along = (thigh**2 + length**2 - shin**2) / (2 * length)
    aside = np.sqrt(np.maximum(thigh**2 - along**2, 0.0))
    bent = start + axis * along[:, None] + side_way * aside[:, None]
    stop = start + axis * length[:, None]
    rest_pole = np.array([0.0, -1.0, 0.0])
    for joint, tail, head, rest_vector in (
        (hip, start, bent, REST[knee] - REST[hip]),
        (knee, bent, stop, REST[end] - REST[knee]),
    ):
        rotations[:, joint] = _frame(head - tail, side_way) @ _frame(rest_vector[None], rest_pole[None])[0].T
        positions[:, joint] = tail
    rotations[:, end], rotations[:, toe] = foot, toes
    positions[:, end] = stop
    positions[:, toe] = stop + foot @ (REST[toe] - REST[end])


def _frame(axis: np.ndarray, pole: np.ndarray) -> np.ndarray:
    first = unit(axis)
    second = unit(pole - first * np.sum(pole * first, -1, keepdims=True))
    return np.stack([first, second, np.cross(first, second)], -1)
