"""What the capture itself does around the seams: the measure of every jump."""

import numpy as np

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.closest import ClosestPoints
from unstructured_mg.geometry.components import significant_faces
from unstructured_mg.synthesis.align import vertex_areas
from unstructured_mg.synthesis.frames import Frames
from unstructured_mg.synthesis.images import captured_images
from unstructured_mg.synthesis.project import project_colors, smooth_normals
from unstructured_mg.synthesis.texture_options import TextureOptions
from unstructured_mg.tracking.pair import TrackedPair

# Points taken of each surface to measure the distance between two.
SAMPLES = 4000


def end_steps(pair: TrackedPair) -> list[tuple[int, int]]:
    """Positions of neighbouring frames at both ends of both windows, where transitions begin and end."""
    firsts = [first for window in pair.windows for first in (window.start, window.stop - 2)]
    return [(first, first + 1) for first in firsts]


def surface_distance(
    first_vertices: np.ndarray, first_faces: np.ndarray, second_vertices: np.ndarray, second_faces: np.ndarray
) -> float:
    """Two-sided rms distance (metres) between two surfaces, debris left out: blind to motion along the surface."""
    first = ClosestPoints(first_vertices, first_faces[significant_faces(first_vertices, first_faces)])
    second = ClosestPoints(second_vertices, second_faces[significant_faces(second_vertices, second_faces)])
    squared = [of.query(_samples(near))[0].mean() for of, near in ((first, second), (second, first))]
    return float(np.sqrt(np.mean(squared)))


def _samples(surface: ClosestPoints) -> np.ndarray:
    used = np.unique(surface.faces)
    return surface.vertices[used[:: -(-len(used) // SAMPLES)]]


def surface_change(frames: Frames, pair: TrackedPair) -> float:
    """The capture's largest change of surface (metres) from frame to frame at the windows' ends."""
    changes = []
    for positions in end_steps(pair):
        first, second = (frames.read(int(pair.frames[i])) for i in positions)
        changes.append(surface_distance(first.vertices, first.faces, second.vertices, second.faces))
    return max(changes)


def colour_change(frames: Frames, pair: TrackedPair, options: TextureOptions) -> float | None:
    """The capture's largest change of colour from frame to frame at the windows' ends; None without textures.

    Mean absolute difference, in sRGB grey levels, at the tracked vertices that both frames give a colour, by area.
    """
    changes = []
    for positions in end_steps(pair):
        found = [_vertex_colours(frames.read(int(pair.frames[i])), pair, i, options) for i in positions]
        if found[0] is None or found[1] is None:
            return None
        (first, first_seen), (second, second_seen) = found[0], found[1]
        masses = vertex_areas(pair.vertices[positions[0]], pair.faces) * (first_seen & second_seen)
        if masses.sum() > 0:
            changes.append(float(masses @ np.abs(first - second).mean(axis=1) / masses.sum()))
    return max(changes, default=None)


def _vertex_colours(
    mesh: TexturedMesh, pair: TrackedPair, position: int, options: TextureOptions
) -> tuple[np.ndarray, np.ndarray] | None:
    if not mesh.textures and mesh.colors is None:
        return None
    vertices = pair.vertices[position]
    return project_colors(
        mesh,
        captured_images(mesh, options.texture_size),
        vertices,
        smooth_normals(vertices, pair.faces),
        options.projection_reach,
        options.normal_agreement,
    )
