"""Which frame lends its connectivity to a pair (P section 5.1)."""

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.geometry.components import face_components
from unstructured_mg.geometry.laplacian import face_areas
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.surface import clean_surface


def window_frames(candidate: Candidate) -> np.ndarray:
    """The int32 frame indices of a pair: the source's window, then the target's."""
    return np.concatenate([np.arange(window.start, window.stop) for window in candidate.windows]).astype(np.int32)


def template_rank(vertices: np.ndarray, faces: np.ndarray, debris_share: float) -> tuple[int, int, float]:
    """What P section 5.1 compares, larger is better: significant components, minus genus, area in square metres.

    Both counts are taken after welding and over significant components. Genus is that of the components together,
    from V - E + F = 2 C - 2 g with every boundary loop closed by a face; duplicate and zero-area faces do not count.
    """
    surface = clean_surface(vertices, faces, debris_share)
    solid = surface.faces[surface.geometric]
    used = np.zeros(len(surface.vertices), bool)
    used[solid.ravel()] = True
    compact = (np.cumsum(used) - 1)[solid]
    count = int(used.sum())
    components = int(face_components(count, compact.astype(np.int32)).max()) + 1
    start, end = compact.ravel(), np.roll(compact, -1, axis=1).ravel()
    edges, faces_there = np.unique(np.maximum(start, end) * count + np.minimum(start, end), return_counts=True)
    boundary = edges[faces_there == 1]
    loops = _boundary_loops(count, np.stack([boundary // count, boundary % count], axis=1))
    characteristic = count - len(edges) + len(compact) + loops
    genus = max(0, round((2 * components - characteristic) / 2))
    return components, -genus, float(face_areas(surface.vertices, solid).sum())


def _boundary_loops(vertex_count: int, boundary: np.ndarray) -> int:
    """Independent cycles of the boundary edges: loops that touch in a vertex count one by one."""
    if len(boundary) == 0:
        return 0
    pieces = int(face_components(vertex_count, boundary[:, [0, 1, 0]]).max()) + 1
    return len(boundary) - len(np.unique(boundary)) + pieces


def select_template(capture: Capture, candidate: Candidate, options: TrackingOptions) -> int:
    """The frame index of the best template among the pair's 4 k + 2 frames; the earliest of equals."""
    frames = np.unique(window_frames(candidate))
    ranks = []
    for frame in frames:
        mesh = capture.read(int(frame))
        ranks.append(template_rank(mesh.vertices, mesh.faces, options.debris_share))
    return int(frames[max(range(len(frames)), key=lambda i: (ranks[i], -i))])
