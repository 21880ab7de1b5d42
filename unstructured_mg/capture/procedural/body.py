"""The procedural figure's surface at rest: a smooth implicit body, its closed mesh and its skinning weights."""

from dataclasses import dataclass
from functools import lru_cache

import igl
import numpy as np
import scipy.sparse as sp
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator

from unstructured_mg.capture.procedural.remesh import coarsen, flip_edges, opposite_half_edges
from unstructured_mg.capture.procedural.skeleton import INDEX, REST
from unstructured_mg.geometry.laplacian import mass_matrix, stiffness_matrix
from unstructured_mg.geometry.solver import SymmetricSolver

GRID = 0.010  # metres: marching-cubes spacing, fine enough for a thumb


FACES = 30_000  # of the reference surface


@dataclass(frozen=True)
class Loft:
    """A limb: an elliptical section swept along a segment.

    ``stations`` are (t in 0..1, half-width across ``side``, half-width across the third axis), ``blend`` is the length
    over which it melts into what is already there, ``bone`` the joint that carries it.
    """

    bone: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    stations: tuple[tuple[float, float, float], ...]
    side: tuple[float, float, float] = (1.0, 0.0, 0.0)
    blend: float = 0.02

    def distance(self, points: np.ndarray) -> np.ndarray:
        """About the signed distance (p,) of points (p, 3), exact in sign."""
        a, b = np.array(self.start), np.array(self.end)
        length = np.linalg.norm(b - a)
        w = (b - a) / length
        u = np.array(self.side) - w * (w @ np.array(self.side))
        u /= np.linalg.norm(u)
        v = np.cross(w, u)
        t_keys, u_keys, v_keys = np.array(self.stations).T
        q = points - a
        # Not by BLAS: its rounding may depend on the number of threads.
        along, across, third = (np.einsum("pi,i->p", q, way) for way in (w, u, v))
        t = np.clip(along / length, 0.0, 1.0)
        ru, rv = (PchipInterpolator(t_keys, keys)(t) if len(t_keys) > 1 else keys for keys in (u_keys, v_keys))
        cap = np.minimum(ru, rv)
        return (np.sqrt((across / ru) ** 2 + (third / rv) ** 2 + ((along - t * length) / cap) ** 2) - 1) * cap

    def box(self, margin: float) -> tuple[np.ndarray, np.ndarray]:
        radius = max(max(s[1:]) for s in self.stations) + margin
        ends = np.array([self.start, self.end])
        return ends.min(0) - radius, ends.max(0) + radius


def _mirrored(parts: list[Loft]) -> list[Loft]:
    def flip(p: tuple[float, float, float]) -> tuple[float, float, float]:
        return (-p[0], p[1], p[2])

    both = []
    for part in parts:
        both.append(part)
        name = part.bone.replace("left", "right")
        both.append(Loft(name, flip(part.start), flip(part.end), part.stations, flip(part.side), part.blend))
    return both


def _at(joint: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> tuple[float, float, float]:
    p = REST[INDEX[joint]]
    return (float(p[0] + x), float(p[1] + y), float(p[2] + z))


def _ball(bone: str, centre: tuple[float, float, float], rx: float, ry: float, rz: float, blend: float = 0.02) -> Loft:
    """An ellipsoid, as a loft of next to no length along z."""
    x, y, z = centre
    half = max(rz - min(rx, ry), 0.0)
    return Loft(bone, (x, y, z - half - 1e-4), (x, y, z + half + 1e-4), ((0.0, rx, ry),), (1.0, 0.0, 0.0), blend)


def _hand() -> list[Loft]:
    wrist = REST[INDEX["left_wrist"]]
    w = wrist - REST[INDEX["left_elbow"]]
    w = w / np.linalg.norm(w)  # towards the fingers
    across = np.array([-0.25, -1.0, 0.0])  # towards the thumb
    across -= w * (w @ across)
    across /= np.linalg.norm(across)
    palm = np.cross(w, across)  # out of the back of the hand or into the palm
    if palm[0] > 0:
        palm = -palm

    def at(along: float, aside: float, inward: float = 0.0) -> tuple[float, float, float]:
        p = wrist + along * w + aside * across + inward * palm
        return (float(p[0]), float(p[1]), float(p[2]))

    side = (float(across[0]), float(across[1]), float(across[2]))
    parts = [
        Loft(
            "left_wrist",
            at(0.005, 0),
            at(0.082, 0.002),
            ((0.0, 0.027, 0.021), (0.55, 0.042, 0.019), (1.0, 0.041, 0.0155)),
            side,
            0.02,
        )
    ]
    for i, (aside, length) in enumerate(((0.0315, 0.060), (0.0108, 0.068), (-0.0105, 0.063), (-0.0305, 0.050))):
        knuckle, middle = at(0.082, 0.97 * aside), at(0.082 + 0.55 * length, aside, 0.004 + 0.001 * i)
        tip = at(0.078 + length, 0.96 * aside, 0.016 + 0.002 * i)
        parts.append(Loft("left_wrist", knuckle, middle, ((0.0, 0.0115, 0.0115), (1.0, 0.0112, 0.0112)), side, 0.005))
        parts.append(Loft("left_wrist", middle, tip, ((0.0, 0.0112, 0.0112), (1.0, 0.0098, 0.0098)), side, 0.005))
    parts.append(
        Loft(
            "left_wrist",
            at(0.022, 0.030, 0.008),
            at(0.055, 0.056, 0.020),
            ((0.0, 0.016, 0.016), (1.0, 0.0128, 0.0128)),
            side,
            0.014,
        )
    )
    parts.append(
        Loft(
            "left_wrist",
            at(0.055, 0.056, 0.020),
            at(0.083, 0.063, 0.026),
            ((0.0, 0.0128, 0.0128), (1.0, 0.0108, 0.0108)),
            side,
            0.004,
        )
    )
    return parts


def _parts() -> list[Loft]:
    shoulder, elbow, wrist = (_at(f"left_{name}") for name in ("shoulder", "elbow", "wrist"))
    hip, knee, ankle = (_at(f"left_{name}") for name in ("hip", "knee", "ankle"))
    front = (0.0, 1.0, 0.0)
    torso = [
        Loft(
            "spine",
            (0, 0.004, 0.90),
            (0, 0.012, 1.44),
            (
                (0.0, 0.158, 0.112),
                (0.18, 0.150, 0.108),
                (0.36, 0.146, 0.105),
                (0.68, 0.168, 0.118),
                (0.86, 0.160, 0.104),
                (1.0, 0.095, 0.074),
            ),
            blend=0.02,
        ),
        Loft("pelvis", (0, 0.012, 0.905), (0, 0.004, 1.00), ((0.0, 0.160, 0.114), (1.0, 0.150, 0.108)), blend=0.03),
        Loft("neck", (0, 0.022, 1.40), (0, 0.008, 1.56), ((0.0, 0.054, 0.054), (1.0, 0.046, 0.049)), blend=0.035),
    ]
    limbs = _mirrored(
        [
            Loft(
                "left_clavicle",
                (0.06, 0.012, 1.395),
                (0.165, 0.012, 1.398),
                ((0.0, 0.060, 0.060), (1.0, 0.056, 0.056)),
                front,
                0.05,
            ),
            Loft(
                "left_shoulder",
                shoulder,
                elbow,
                ((0.0, 0.062, 0.060), (0.35, 0.054, 0.053), (1.0, 0.041, 0.042)),
                front,
                0.045,
            ),
            Loft(
                "left_elbow",
                elbow,
                wrist,
                ((0.0, 0.041, 0.042), (0.32, 0.045, 0.042), (1.0, 0.027, 0.024)),
                front,
                0.025,
            ),
            Loft("left_hip", hip, knee, ((0.0, 0.096, 0.090), (0.45, 0.080, 0.080), (1.0, 0.057, 0.058)), front, 0.05),
            Loft(
                "left_hip",
                (0.075, 0.055, 0.915),
                (0.085, 0.045, 0.86),
                ((0.0, 0.072, 0.075), (1.0, 0.07, 0.07)),
                blend=0.06,
            ),
            Loft(
                "left_knee",
                knee,
                ankle,
                ((0.0, 0.057, 0.057), (0.28, 0.062, 0.055), (0.7, 0.047, 0.045), (1.0, 0.044, 0.043)),
                front,
                0.03,
            ),
            Loft(
                "left_ankle",
                (0.139, 0.030, 0.048),
                (0.149, -0.100, 0.040),
                ((0.0, 0.041, 0.048), (0.55, 0.047, 0.054), (1.0, 0.051, 0.040)),
                blend=0.035,
            ),
            Loft(
                "left_toe",
                (0.148, -0.095, 0.036),
                (0.152, -0.160, 0.032),
                ((0.0, 0.051, 0.040), (1.0, 0.046, 0.033)),
                blend=0.02,
            ),
            *_hand(),
        ]
    )
    head = [
        _ball("head", (0, 0.008, 1.640), 0.090, 0.102, 0.108, 0.02),
        Loft("head", (0, -0.020, 1.560), (0, -0.010, 1.600), ((0.0, 0.052, 0.066), (1.0, 0.073, 0.083)), blend=0.03),
        _ball("head", (0, -0.068, 1.531), 0.025, 0.024, 0.022, 0.035),
        Loft("head", (0, -0.096, 1.632), (0, -0.111, 1.598), ((0.0, 0.009, 0.009), (1.0, 0.015, 0.014)), blend=0.014),
        *_mirrored(
            [
                Loft(
                    "head",
                    (0.090, 0.010, 1.592),
                    (0.097, 0.016, 1.630),
                    ((0.0, 0.009, 0.016), (1.0, 0.010, 0.022)),
                    blend=0.008,
                ),
                _ball("head", (0.042, -0.064, 1.594), 0.024, 0.021, 0.022, 0.035),
            ]
        ),
    ]
    return torso + limbs + head


def _hair() -> list[Loft]:
    fringe = ((0.0, 0.026, 0.026), (0.55, 0.031, 0.030), (1.0, 0.016, 0.014))
    temple = ((0.0, 0.030, 0.022), (1.0, 0.014, 0.012))
    upright = (0.0, 0.0, 1.0)
    return [
        _ball("head", (0, 0.022, 1.660), 0.103, 0.107, 0.112, 0.01),
        Loft("head", (0, 0.066, 1.600), (0, 0.074, 1.545), ((0.0, 0.078, 0.045), (1.0, 0.056, 0.030)), blend=0.04),
        Loft("head", (0.050, -0.072, 1.722), (-0.048, -0.084, 1.712), fringe, upright, 0.025),
        Loft("head", (-0.020, -0.066, 1.738), (0.062, -0.066, 1.708), fringe, upright, 0.025),
        Loft("head", (0.058, -0.050, 1.730), (0.089, -0.008, 1.672), temple, upright, 0.035),
        Loft("head", (-0.058, -0.050, 1.730), (-0.089, -0.008, 1.672), temple, upright, 0.035),
        Loft(
            "head",
            (0.018, -0.030, 1.748),
            (-0.014, 0.045, 1.754),
            ((0.0, 0.050, 0.028), (1.0, 0.046, 0.026)),
            blend=0.05,
        ),
    ]


def _step(x: np.ndarray, width: float) -> np.ndarray:
    """0 below ``-width / 2``, 1 above ``width / 2``, smooth between."""
    t = np.clip(x / width + 0.5, 0.0, 1.0)
    return t * t * (3 - 2 * t)


def sleeve_coordinate(points: np.ndarray) -> np.ndarray:
    """How far (p,) metres points lie along the upper arm of their side, from the shoulder on; -0.1 on the trunk."""
    shoulder, elbow = REST[INDEX["left_shoulder"]], REST[INDEX["left_elbow"]]
    w = (elbow - shoulder) / np.linalg.norm(elbow - shoulder)
    mirrored = np.stack([np.abs(points[:, 0]), points[:, 1], points[:, 2]], 1)
    return np.where(mirrored[:, 0] > 0.205, np.einsum("pi,i->p", mirrored - shoulder, w), -0.1)


def relative_size(points: np.ndarray) -> np.ndarray:
    """How long edges (p,) should be around points of the body: 1 on the trunk, shorter on head, hands and feet."""
    x, _, z = points.T
    head = 1 / (1 + np.exp(-(z - 1.50) / 0.012))
    hand = 1 / (1 + np.exp(-(np.abs(x) - 0.55) / 0.010))
    feet = 1 / (1 + np.exp((z - 0.10) / 0.015))
    return 1 - 0.58 * head - 0.60 * hand - 0.30 * feet


SLEEVE_END = 0.165
HEM = 0.935
CUFF = 0.100


def hem_height(points: np.ndarray) -> np.ndarray:
    """Height (p,) of the shirt's hem: a little lower behind."""
    return HEM - 0.08 * points[:, 1]


def neck_coordinate(points: np.ndarray) -> np.ndarray:
    """Positive (p,) metres inside the collar's opening, an ellipsoid that dips in front, and above it."""
    x, y, z = points.T
    reach = np.sqrt((x / 0.086) ** 2 + ((y + 0.004) / 0.092) ** 2 + ((z - 1.475) / 0.066) ** 2)
    return np.maximum(0.07 * (1 - reach), z - 1.50)


def hair_coordinate(points: np.ndarray) -> np.ndarray:
    """Positive where the scalp carries hair: above the brow, behind the ears, down to the nape."""
    x, y, z = points.T
    front = (
        0.85 * (y + 0.047)
        + 0.75 * (z - 1.674)
        - 0.6 * (np.abs(x) - 0.06).clip(0, 0.03) * (1.66 - z).clip(0, 0.05) / 0.05
    )
    return np.minimum(front, z - 1.535)


def _clothes(points: np.ndarray) -> np.ndarray:
    """Thickness (p,) of cloth over the body."""
    arm = sleeve_coordinate(points)
    near_arm = np.abs(points[:, 0]) > 0.3
    hem = hem_height(points)
    shirt = _step(points[:, 2] - hem, 0.007) * _step(SLEEVE_END - arm, 0.007) * _step(-neck_coordinate(points), 0.008)
    flare = 0.006 * np.exp(-(((points[:, 2] - hem) / 0.08) ** 2)) * ~near_arm
    flare = flare + 0.004 * np.exp(-(((arm - SLEEVE_END) / 0.06) ** 2))
    legs = _step(hem - points[:, 2], 0.007) * _step(points[:, 2] - CUFF, 0.007) * ~near_arm
    cuff = 0.010 * np.exp(-(((points[:, 2] - CUFF) / 0.09) ** 2))
    return shirt * (0.011 + flare) + legs * (0.003 + cuff)


class Implicit:
    """The body as a function that is negative inside, about a distance near its zero set."""

    def __init__(self) -> None:
        self.parts = _parts()
        self.hair = _hair()

    def __call__(self, points: np.ndarray) -> np.ndarray:
        body = np.full(len(points), 0.2)
        for part in self.parts:
            _melt(body, part, points)
        body -= _clothes(points)
        # Soles are flat on the floor.
        body = _smooth_maximum(body, -points[:, 2], 0.012)
        hair = np.full(len(points), 0.2)
        for part in self.hair:
            _melt(hair, part, points)
        hair = _smooth_maximum(hair, -hair_coordinate(points), 0.012)
        return _smooth_minimum(body, hair, 0.006)


def _smooth_minimum(a: np.ndarray, b: np.ndarray, blend: float) -> np.ndarray:
    h = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.minimum(a, b) - h * h * h * blend / 6


def _smooth_maximum(a: np.ndarray, b: np.ndarray, blend: float) -> np.ndarray:
    return -_smooth_minimum(-a, -b, blend)


def _melt(field: np.ndarray, part: Loft, points: np.ndarray) -> None:
    low, high = part.box(part.blend + 0.04)
    near = np.flatnonzero(((points >= low) & (points <= high)).all(1))
    field[near] = _smooth_minimum(field[near], part.distance(points[near]), part.blend)


@dataclass(frozen=True)
class Body:
    """The reference surface at rest.

    Attributes
    ----------
    vertices : (n, 3) float64, metres, z up, floor at 0
    faces : (m, 3) int32, closed, genus 0
    weights : (n, joints) float64 skinning weights, rows sum to 1
    shade : (n,) float64 share of the sky seen, 0..1
    opposite : (3 m,) int32, the corner table of ``faces``
    """

    vertices: np.ndarray
    faces: np.ndarray
    weights: np.ndarray
    shade: np.ndarray
    opposite: np.ndarray


@lru_cache(maxsize=1)
def reference_body() -> Body:
    """Mesh the implicit body once a process; the same arrays every time."""
    implicit = Implicit()
    low, high = np.array([-0.80, -0.26, -0.03]), np.array([0.80, 0.22, 1.83])
    counts = np.ceil((high - low) / GRID).astype(int)
    # Offset off round numbers: no grid plane may coincide with the body's plane of symmetry or the floor.
    axes = [low[i] + GRID * (np.arange(counts[i]) + 0.37) for i in range(3)]
    grid, values = _sample(implicit, axes)
    vertices, faces, _ = igl.marching_cubes(values, grid, *(int(c) for c in counts), 0.0)
    faces = np.ascontiguousarray(faces, np.int32)
    if _signed_volume(vertices, faces) < 0:
        faces = np.ascontiguousarray(faces[:, ::-1])
    vertices, faces, opposite = _polish(implicit, vertices, faces)
    return Body(vertices, faces, _skin_weights(implicit, vertices, faces), _shade(implicit, vertices, faces), opposite)


def _sample(implicit: Implicit, axes: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Grid points (x fastest) and the implicit function on them: exact near its zero set, elsewhere interpolated."""

    def mesh(ways: list[np.ndarray]) -> np.ndarray:
        z, y, x = np.meshgrid(ways[2], ways[1], ways[0], indexing="ij")
        return np.stack([x.ravel(), y.ravel(), z.ravel()], 1)

    coarse = [np.arange(way[0], way[-1] + 3 * GRID, 3 * GRID) for way in axes]
    rough = implicit(mesh(coarse)).reshape([len(way) for way in reversed(coarse)])
    grid = mesh(axes)
    values = RegularGridInterpolator(coarse[::-1], rough)(grid[:, ::-1])
    near = np.flatnonzero(np.abs(values) < 4 * GRID)
    values[near] = implicit(grid[near])
    return grid, values


def _signed_volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _neighbour_mean(count: int, faces: np.ndarray) -> sp.csr_matrix:
    rows = np.concatenate([faces[:, 0], faces[:, 1], faces[:, 2]])
    columns = np.concatenate([faces[:, 1], faces[:, 2], faces[:, 0]])
    adjacency = sp.csr_matrix((np.ones(len(rows)), (rows, columns)), (count, count))
    return sp.diags(1.0 / np.asarray(adjacency.sum(1)).ravel()) @ adjacency


def _polish(implicit: Implicit, vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Even out marching cubes' slivers along the surface and bring every vertex onto the zero set."""
    opposite = opposite_half_edges(faces)
    for attempt in range(9):
        if attempt == 4:
            # The trunk and the limbs carry no detail: a third of the faces can go, and every frame is posed faster.
            kept, faces = coarsen(faces, opposite, vertices, GRID * (0.35 + relative_size(vertices)), 0, FACES)
            vertices, opposite = vertices[kept], opposite_half_edges(faces)
        flip_edges(faces, opposite, vertices, 3)
        normal = igl.per_vertex_normals(vertices, faces)
        pull = _neighbour_mean(len(vertices), faces) @ vertices - vertices
        vertices = vertices + 0.6 * (pull - normal * np.sum(pull * normal, 1, keepdims=True))
        vertices -= np.clip(implicit(vertices), -0.3 * GRID, 0.3 * GRID)[:, None] * normal
    flip_edges(faces, opposite, vertices, 3)
    return vertices, faces, opposite


def _skin_weights(implicit: Implicit, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Nearest-part indicators diffused along the surface: (M + t S) w = M indicator, t a transition length squared."""
    distances = np.stack([part.distance(vertices) for part in implicit.parts + implicit.hair], 1)
    bones = np.array([INDEX[part.bone] for part in implicit.parts + implicit.hair])
    nearest = bones[np.argmin(distances, 1)]
    # The trunk is one loft: its bones take it in turns by height.
    trunk = np.isin(nearest, [INDEX["pelvis"], INDEX["spine"], INDEX["chest"]])
    heights = np.array([1.02, 1.17])
    order = np.array([INDEX["pelvis"], INDEX["spine"], INDEX["chest"]])
    nearest[trunk] = order[np.searchsorted(heights, vertices[trunk, 2])]
    indicator = np.zeros((len(vertices), len(REST)))
    indicator[np.arange(len(vertices)), nearest] = 1.0
    mass, stiffness = mass_matrix(vertices, faces), stiffness_matrix(vertices, faces)
    solver = SymmetricSolver((mass + 0.025**2 * stiffness).tocsc())
    weights = np.maximum(solver.solve(mass @ solver.solve(mass @ indicator)), 0.0)
    weights[weights < 1e-4] = 0.0
    return weights / weights.sum(1, keepdims=True)


def _shade(implicit: Implicit, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Ambient occlusion from the implicit function: how fast room opens along the normal."""
    normal = igl.per_vertex_normals(vertices, faces)
    closed = np.zeros(len(vertices))
    for reach, share in ((0.015, 0.5), (0.04, 0.3), (0.09, 0.2)):
        room = implicit(vertices + reach * normal) / reach
        closed += share * np.clip(1 - room, 0.0, 1.0)
    return 1 - closed
