"""One candidate to one TrackedPair, or to a refusal (P section 5, TrackTemplate)."""

from dataclasses import dataclass

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import Refusal
from unstructured_mg.geometry.morton import morton_order
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.tracking.cage import Cage, build_lattice
from unstructured_mg.tracking.detail import transfer_detail
from unstructured_mg.tracking.embedding import residual_of
from unstructured_mg.tracking.hausdorff import SurfaceDistance, surface_distance
from unstructured_mg.tracking.interior import Interior
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.pair import TrackedPair
from unstructured_mg.tracking.refine import Refiner
from unstructured_mg.tracking.register import Registrar, far_stages
from unstructured_mg.tracking.stretch import Stretch
from unstructured_mg.tracking.surface import clean_surface
from unstructured_mg.tracking.target import Target
from unstructured_mg.tracking.template import window_frames

# Of a body of 2 square metres; others are scaled by the root of their area.
_REFINE_LENGTH, _REFINE_REACH, _REFINE_ROUNDS = 0.0125, 0.03, 3
_INTERIOR_SOFTNESS, _INTERIOR_ROUNDS = 1e-6, 1
# The trial of s against t needs no fine cage and no fine stages: it is there to refuse.
_TRIAL_CAGE_VERTICES, _TRIAL_RIGIDITY = 700, 1e-3


@dataclass(frozen=True)
class TrackedState:
    """The template at one frame: its cage (c, 3) as registered, and the numbers and arrays kept of it."""

    cage: np.ndarray
    fitted_cage: np.ndarray
    vertices: np.ndarray
    residual: np.ndarray
    distance: SurfaceDistance
    inverted: int
    strain: float


class TemplateTracker:
    """Carries one template through frames: everything that depends only on the template is prepared once.

    ``mesh`` is the template frame, ``cage`` what ``build_cage`` made of it.
    """

    def __init__(self, mesh: TexturedMesh, cage: Cage, options: TrackingOptions):
        self.mesh, self.options = mesh, options
        self.surface = clean_surface(mesh.vertices, mesh.faces, options.debris_share)
        if len(cage.tet_of_vertex) != len(self.surface.vertices):
            raise ValueError(
                f"cage: expected one that carries {len(self.surface.vertices)} vertices, got {len(cage.tet_of_vertex)}"
            )
        self.cage = cage
        self.registrar = Registrar(self.surface, cage)
        scale = self.registrar.scale
        self._refiner = Refiner(self.surface, _REFINE_LENGTH * scale, _REFINE_REACH * scale)
        areas = self.registrar.areas
        self._interior = Interior(cage, self.registrar.system, areas, scale, _INTERIOR_SOFTNESS)
        faces = self.registrar.faces
        self._edges = np.unique(
            np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), 1), axis=0
        )
        self._lengths = self._edge_lengths(self.surface.vertices)
        self._order = morton_order(self.surface.vertices[faces].sum(axis=1))

    def _edge_lengths(self, vertices: np.ndarray) -> np.ndarray:
        return np.linalg.norm(vertices[self._edges[:, 0]] - vertices[self._edges[:, 1]], axis=1)

    def target(self, mesh: TexturedMesh) -> Target:
        return self.registrar.target(clean_surface(mesh.vertices, mesh.faces, self.options.debris_share))

    def at_rest(self, target: Target) -> TrackedState:
        """The state at the template's own frame."""
        return self._finish(self.cage.vertices, self.cage.vertices, self.surface.vertices, target)

    def place(self, start: np.ndarray, target: Target) -> np.ndarray:
        """Cage vertices (c, 3) on a target, from those of a neighbouring or of a similar, roughly placed frame."""
        stages = self.registrar.stages(target, start, self.options.rigidity)
        return self.registrar.register(target, start, stages)

    def refined(self, cage_vertices: np.ndarray, target: Target) -> np.ndarray:
        """The surface (n, 3) that placed cage vertices carry, brought onto the target; with its detail if so opted."""
        vertices = self._refiner.refine(self.registrar.surface_at(cage_vertices), target, _REFINE_ROUNDS)
        if self.options.detail:
            vertices = transfer_detail(vertices, self.registrar.faces, target.vertices, target.faces, self.options)
        return vertices

    def finish(self, cage_vertices: np.ndarray, target: Target) -> TrackedState:
        """Refine the surface that placed cage vertices carry, fit the interior to it, measure it."""
        vertices = self.refined(cage_vertices, target)
        fitted = self._interior.fit(cage_vertices, vertices, _INTERIOR_ROUNDS)
        return self._finish(cage_vertices, fitted, vertices, target)

    def follow(self, start: np.ndarray, target: Target) -> TrackedState:
        """``place`` and ``finish``: track to one frame."""
        return self.finish(self.place(start, target), target)

    def strain(self, vertices: np.ndarray) -> float:
        """Root mean square of the relative change of edge lengths against the template."""
        lengths = self._edge_lengths(vertices)
        return float(np.sqrt(np.mean((lengths / np.maximum(self._lengths, 1e-9) - 1) ** 2)))

    def _finish(
        self, cage_vertices: np.ndarray, fitted: np.ndarray, vertices: np.ndarray, target: Target
    ) -> TrackedState:
        cage = self.cage
        _, rotations = self.registrar.system.rotations(fitted)
        residual = residual_of(vertices, fitted, cage.tets, cage.tet_of_vertex, cage.weights, rotations)
        distance = surface_distance(vertices, self.registrar.faces, self.registrar.areas, target, self._order)
        inverted = int((tet_volumes(fitted, cage.tets) <= 0).sum())
        return TrackedState(cage_vertices, fitted, vertices, residual, distance, inverted, self.strain(vertices))


def track_pair(
    capture: Capture, candidate: Candidate, template: int, cage: Cage, options: TrackingOptions
) -> TrackedPair | Refusal:
    """Fit one template to all frames of a pair, or say why not.

    ``template`` is a frame index of the pair, ``cage`` from ``build_cage`` of that frame. A trial of frame s's own
    surface against t comes first: most pairs that will be refused then cost one registration. Then the template goes
    from its frame outwards through its window, across between s and t, and outwards through the other window.
    """
    frames = window_frames(candidate)
    if template not in frames:
        raise ValueError(f"template: expected one of the pair's frames, got {template}")
    source, target = candidate.source, candidate.target
    meshes: dict[int, TexturedMesh] = {}

    def read(frame: int) -> TexturedMesh:
        if frame not in meshes:
            meshes[frame] = capture.read(frame)
        return meshes[frame]

    refusal = _trial(read(source), read(target), candidate, options)
    if refusal is not None:
        return refusal
    tracker = TemplateTracker(read(template), cage, options)
    states = {template: tracker.at_rest(tracker.target(read(template)))}
    inside, outside = candidate.windows
    home, away = source, target
    if template not in inside:
        home, away, inside, outside = target, source, outside, inside
    for order in (_outwards(template, inside), [(home, away)], _outwards(away, outside)):
        for before, frame in order:
            goal = tracker.target(meshes.pop(frame) if frame in meshes else capture.read(frame))
            start = states[before].cage
            if (before, frame) == (home, away):
                yaw = -candidate.yaw if home == source else candidate.yaw
                move = placing(states[before].vertices, tracker.registrar.areas, goal, yaw)
                states[frame] = tracker.follow(move.apply(start), goal)
            else:
                states[frame] = tracker.follow(start, goal)
            what = f"the template at frame {frame}"
            refusal = missed(what, states[frame].distance, options)
            if refusal is None and (before, frame) == (home, away):
                # The frames are alike: what is stretched between them was taken for something else.
                change = Stretch(states[before].vertices, tracker.registrar.faces)
                refusal = overstretched(what, change.p95(states[frame].vertices), options)
            if refusal is not None:
                return refusal
    ordered = [states[int(frame)] for frame in frames]
    measures = {
        "hausdorff_m": np.array([state.distance.largest for state in ordered]),
        "mean_distance_m": np.array([state.distance.mean for state in ordered]),
        "p95_distance_m": np.array([state.distance.p95 for state in ordered]),
        "inverted_tets": np.array([float(state.inverted) for state in ordered]),
        "edge_strain": np.array([state.strain for state in ordered]),
    }
    return _pair(tracker, candidate, frames, template, ordered, measures)


def _pair(
    tracker: TemplateTracker,
    candidate: Candidate,
    frames: np.ndarray,
    template: int,
    states: list[TrackedState],
    measures: dict[str, np.ndarray],
) -> TrackedPair:
    mesh, surface, cage = tracker.mesh, tracker.surface, tracker.cage
    kept = surface.face_index[surface.geometric]
    return TrackedPair(
        source=candidate.source,
        target=candidate.target,
        k=candidate.k,
        frames=frames,
        template=int(np.flatnonzero(frames == template)[0]),
        vertices=np.stack([state.vertices for state in states]),
        faces=surface.faces[surface.geometric],
        uv=mesh.uv,
        face_uv=mesh.face_uv[kept] if len(mesh.face_uv) else mesh.face_uv,
        face_material=None if mesh.face_material is None else mesh.face_material[kept],
        cage_vertices=np.stack([state.fitted_cage for state in states]),
        tets=cage.tets,
        tet_of_vertex=cage.tet_of_vertex,
        weights=cage.weights,
        residual=np.stack([state.residual for state in states]),
        yaw=candidate.yaw,
        measures=measures,
        warp=None if candidate.warp is None else _positions(candidate),
    )


def _positions(candidate: Candidate) -> np.ndarray:
    """A warp's frames as positions among the pair's."""
    assert candidate.warp is not None
    (source, target), (own, other) = candidate.warp, candidate.windows
    return np.array([np.subtract(source, own.start), np.subtract(target, other.start) + len(own)], np.int32)


def _outwards(first: int, window: range) -> list[tuple[int, int]]:
    """(tracked, next) pairs from ``first`` to both ends of the window around it."""
    up = [(frame, frame + 1) for frame in range(first, window.stop - 1)]
    down = [(frame, frame - 1) for frame in range(first, window.start, -1)]
    return up + down


def placing(vertices: np.ndarray, areas: np.ndarray, goal: Target, yaw: float) -> PlanarRigid:
    """Turn by ``yaw`` about the vertical and move along the floor to the goal's centre of area."""
    own = np.einsum("n,nx->x", areas, PlanarRigid(yaw=yaw).apply(vertices)) / areas.sum()
    theirs = np.einsum("n,nx->x", goal.areas, goal.vertices) / goal.areas.sum()
    return PlanarRigid(yaw, float(theirs[0] - own[0]), float(theirs[1] - own[1]))


def _trial(
    source: TexturedMesh, target: TexturedMesh, candidate: Candidate, options: TrackingOptions
) -> Refusal | None:
    """Register frame s's surface to t roughly; a refusal where even that is out of reach."""
    surface = clean_surface(source.vertices, source.faces, options.debris_share)
    cage = build_lattice(surface, _TRIAL_CAGE_VERTICES)
    registrar = Registrar(surface, cage)
    goal = registrar.target(clean_surface(target.vertices, target.faces, options.debris_share))
    start = placing(surface.vertices, registrar.areas, goal, -candidate.yaw).apply(cage.vertices)
    stages = [stage for stage in far_stages(_TRIAL_RIGIDITY) if stage.rigidity >= _TRIAL_RIGIDITY]
    reached = registrar.surface_at(registrar.register(goal, start, stages))
    distance = surface_distance(reached, registrar.faces, registrar.areas, goal)
    return missed(f"frame {candidate.source} moved to frame {candidate.target}", distance, options)


def overstretched(what: str, stretch: float, options: TrackingOptions) -> Refusal | None:
    """A refusal where a ``stretch`` (see ``stretch``) between like surfaces is above the limit."""
    if stretch <= options.stretch:
        return None
    return Refusal(
        "tracking",
        f"{what} is stretched or squeezed {stretch:.2f} times on a twentieth of its area, above {options.stretch:g} "
        "times: parts were taken for one another",
        {"stretch_p95": stretch},
    )


def missed(what: str, distance: SurfaceDistance, options: TrackingOptions) -> Refusal | None:
    """A refusal where the two-sided ``distance`` is above the limit."""
    if distance.largest <= options.hausdorff_m:
        return None
    largest, limit = 100 * distance.largest, 100 * options.hausdorff_m
    return Refusal(
        "tracking",
        f"{what} misses the captured surface by {largest:.1f} cm, more than {limit:g} cm",
        {"hausdorff_m": distance.largest, "mean_distance_m": distance.mean, "p95_distance_m": distance.p95},
    )
