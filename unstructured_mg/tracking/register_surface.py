"""Register one surface to another, with nothing else known: the tracker as a library."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import Refusal
from unstructured_mg.tracking.cage import Cage, build_cage
from unstructured_mg.tracking.hausdorff import SurfaceDistance
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.stretch import Stretch
from unstructured_mg.tracking.surface import CleanSurface, clean_surface
from unstructured_mg.tracking.track import TemplateTracker, missed, overstretched, placing


@dataclass(frozen=True)
class RegisteredSurface:
    """The source surface at the target's place.

    Attributes
    ----------
    vertices : (n, 3) float64, every vertex of the source, metres
    tracked : (n,) bool, False for vertices of debris or of no face: they go where the nearest tracked one goes
    distance : two-sided distance between the two surfaces, metres, debris left out
    strain : root mean square of the relative change of edge lengths
    stretch : 95 % of the area are stretched or squeezed at most so many times
    cage, cage_vertices : the source's cage at rest, and (c, 3) at the target
    inverted_tets : cells of the cage that turned inside out
    refusal : why the result must not be trusted, with the numbers behind it; None where nothing speaks against it
    """

    vertices: np.ndarray
    tracked: np.ndarray
    distance: SurfaceDistance
    strain: float
    stretch: float
    cage: Cage
    cage_vertices: np.ndarray
    inverted_tets: int
    refusal: Refusal | None


def register_surface(
    source: TexturedMesh,
    target: TexturedMesh,
    options: TrackingOptions | None = None,
    cage: Cage | None = None,
    yaw: float | None = None,
) -> RegisteredSurface:
    """Bring ``source`` onto ``target``, whose connectivity, vertex count and components may be any others.

    Textures are not looked at. The annealing (see ``register``) is chosen by how far apart the two are.

    Parameters
    ----------
    source, target : surfaces in metres; open, with holes, debris, non-manifold edges or several components
    options : TrackingOptions() if None
    cage : what ``build_cage(source, options)`` gave, where the source is registered to many targets; built here if None
    yaw : where given, the source is first turned by so many radians about the vertical and moved along the floor to the
        target's centre of area; None starts from where it is

    Raises ValueError for surfaces that are empty, without area, not finite or of wrong shape or type. A target out of
    reach is no error: the result then has a ``refusal``.
    """
    options = options or TrackingOptions()
    _checked(source, "source", options)
    goal_surface = _checked(target, "target", options)
    if yaw is not None and not np.isfinite(yaw):
        raise ValueError(f"yaw: expected a finite angle in radians or None, got {yaw}")
    tracker = TemplateTracker(source, cage or build_cage(source, options), options)
    goal = tracker.registrar.target(goal_surface)
    start = tracker.cage.vertices
    if yaw is not None:
        start = placing(tracker.surface.vertices, tracker.registrar.areas, goal, yaw).apply(start)
    state = tracker.follow(start, goal)
    stretch = Stretch(tracker.surface.vertices, tracker.registrar.faces).p95(state.vertices)
    refusal = missed("the source surface", state.distance, options)
    vertices, tracked = _every_vertex(source, tracker.surface, state.vertices)
    return RegisteredSurface(
        vertices=vertices,
        tracked=tracked,
        distance=state.distance,
        strain=state.strain,
        stretch=stretch,
        cage=tracker.cage,
        cage_vertices=state.fitted_cage,
        inverted_tets=state.inverted,
        refusal=refusal or overstretched("the source surface", stretch, options),
    )


def _checked(mesh: TexturedMesh, name: str, options: TrackingOptions) -> CleanSurface:
    try:
        return clean_surface(mesh.vertices, mesh.faces, options.debris_share)
    except ValueError as error:
        raise ValueError(f"{name}.{error}") from error


def _every_vertex(mesh: TexturedMesh, surface: CleanSurface, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 3) of all captured vertices from those (w, 3) of the clean surface, and which have one there."""
    given = np.asarray(mesh.vertices, np.float64)
    clean = np.full(len(given), -1, np.int64)
    clean[mesh.faces[surface.face_index].ravel()] = surface.faces.ravel()
    tracked = clean >= 0
    if not tracked.all():
        clean[~tracked] = cKDTree(surface.vertices).query(given[~tracked])[1]
    return given + (moved - surface.vertices)[clean], tracked
