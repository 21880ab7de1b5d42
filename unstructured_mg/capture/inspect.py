"""What is in a capture and what is wrong with it, measured frame by frame."""

import hashlib
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from unstructured_mg.capture.atlas import SAMPLES, coverage
from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.frame_reader import read_frame
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.capture.progress import Progress
from unstructured_mg.capture.tidy import Tidied
from unstructured_mg.errors import FrameFault
from unstructured_mg.geometry.components import face_components
from unstructured_mg.geometry.laplacian import face_areas

# Twice a triangle's area over its longest side squared below which rounding decides whether it has any.
_FLAT = 1e-9
# Two frames have the same atlas where their used parts of the textures agree in at least this share (intersection over
# union).
_SAME_ATLAS = 0.9
# A component with less of the frame's area than this is debris.
_SIGNIFICANT = 0.01

_CHUNK = 4


@dataclass(frozen=True)
class FrameMeasures:
    """One good frame, after it was tidied (see capture/tidy.py for what that leaves out: the last six counts).

    ``width``, ``depth`` and ``height`` in metres along x, y (floor) and z (up); ``lowest`` vertex above the floor in
    metres; ``components`` of the surface, and how many of them hold 1 % of its area or more; ``boundary_edges`` have
    one face, ``nonmanifold_edges`` three or more; ``flat_faces`` have no area, ``flat_uv_faces`` none in the texture;
    ``uv_outside`` faces with a corner outside [0, 1]; ``texture_used`` and ``texture_overlap``: share of the texture's
    samples that a triangle covers, and share of those that several cover.
    """

    id: str
    vertices: int
    faces: int
    width: float
    depth: float
    height: float
    lowest: float
    components: int
    significant_components: int
    boundary_edges: int
    nonmanifold_edges: int
    flat_faces: int
    uvs: int
    flat_uv_faces: int
    uv_outside: int
    texture_used: float
    texture_overlap: float
    texture_sizes: tuple[tuple[int, int], ...]
    has_colors: bool
    welded_vertices: int
    unused_vertices: int
    collapsed_faces: int
    repeated_faces: int
    facing_away_faces: int
    untextured_faces: int


@dataclass(frozen=True)
class ClipSummary:
    """A clip's good frames: how many, the first and last number, and the gaps as (first, last) number missing in
    each.
    """

    name: str
    frames: int
    first: int
    last: int
    gaps: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Inspection:
    """A capture's own words (folder to warnings, as in Capture) and what was measured.

    ``new_connectivity`` and ``new_atlas`` hold the ids of the frames whose faces, or whose used part of the texture,
    differ from those of the good frame before them.
    """

    folder: str
    fps: float
    unit: float
    up: str
    floor: float
    clips: tuple[ClipSummary, ...]
    frames: tuple[FrameMeasures, ...]
    new_connectivity: tuple[str, ...]
    new_atlas: tuple[str, ...]
    faults: tuple[FrameFault, ...]
    fault_ids: tuple[str, ...]
    warnings: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """JSON-ready; the keys are the fields' names."""
        return asdict(self)


def inspect_capture(capture: Capture, executor: Executor | None = None, progress: Progress | None = None) -> Inspection:
    """Measure every good frame of a capture, in parallel where there is an ``executor``.

    Raises UserError where a file went bad since the capture was opened.
    """
    chunks = [range(start, min(start + _CHUNK, len(capture))) for start in range(0, len(capture), _CHUNK)]
    work = partial(_measure_frames, capture)
    measured: list[tuple[FrameMeasures, bytes, bytes]] = []
    for results in map(work, chunks) if executor is None else executor.map(work, chunks):
        measured += results
        if progress is not None:
            progress(len(measured), len(capture))
    frames = tuple(measures for measures, _, _ in measured)
    pairs = list(zip(measured, measured[1:], strict=False))
    return Inspection(
        folder=str(capture.folder),
        fps=capture.fps,
        unit=capture.unit,
        up=capture.up,
        floor=capture.floor,
        clips=_clips(capture),
        frames=frames,
        new_connectivity=tuple(after.id for (_, old, _), (after, new, _) in pairs if old != new),
        new_atlas=tuple(after.id for (_, _, old), (after, _, new) in pairs if not _same_atlas(old, new)),
        faults=capture.faults,
        fault_ids=tuple(capture.id_of(fault.clip, fault.number) for fault in capture.faults),
        warnings=capture.warnings,
    )


def _clips(capture: Capture) -> tuple[ClipSummary, ...]:
    clips = []
    for name in capture.clips:
        numbers = [frame.number for frame in capture.frames if frame.clip == name]
        if numbers:
            gaps = tuple((a + 1, b - 1) for a, b in zip(numbers, numbers[1:], strict=False) if b > a + 1)
            clips.append(ClipSummary(name, len(numbers), numbers[0], numbers[-1], gaps))
    return tuple(clips)


def _same_atlas(old: bytes, new: bytes) -> bool:
    if len(old) != len(new):
        return False
    a, b = np.frombuffer(old, np.uint8), np.frombuffer(new, np.uint8)
    union = int(np.bitwise_count(a | b).sum())
    return union == 0 or int(np.bitwise_count(a & b).sum()) >= _SAME_ATLAS * union


def _measure_frames(capture: Capture, indices: range) -> list[tuple[FrameMeasures, bytes, bytes]]:
    """Of each frame its measures, a hash of its faces, and its coverage of the texture as packed bits."""
    matrix = capture.to_metres()
    measured = []
    for index in indices:
        mesh, tidied, _ = read_frame(capture.frames[index], capture.folder)
        vertices = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        counts = np.zeros((0, SAMPLES, SAMPLES), np.int32)
        if len(mesh.face_uv):
            counts = coverage(mesh.uv, mesh.face_uv, mesh.face_material)
        measures = _measure(capture.frame_id(index), mesh, vertices, tidied, counts)
        measured.append((measures, hashlib.sha256(mesh.faces.tobytes()).digest(), np.packbits(counts > 0).tobytes()))
    return measured


def _measure(
    frame_id: str, mesh: TexturedMesh, vertices: np.ndarray, tidied: Tidied, counts: np.ndarray
) -> FrameMeasures:
    labels = face_components(len(vertices), mesh.faces)
    areas = face_areas(vertices, mesh.faces)
    shares = np.bincount(labels, areas) / areas.sum()
    uses = _edge_uses(len(vertices), mesh.faces)
    size = np.ptp(vertices, axis=0)
    outside = np.any((mesh.uv < 0) | (mesh.uv > 1), axis=1, keepdims=True)[:, 0]
    used = int(np.count_nonzero(counts))
    return FrameMeasures(
        id=frame_id,
        vertices=len(vertices),
        faces=len(mesh.faces),
        width=float(size[0]),
        depth=float(size[1]),
        height=float(size[2]),
        lowest=float(vertices[:, 2].min()),
        components=len(shares),
        significant_components=int(np.count_nonzero(shares >= _SIGNIFICANT)),
        boundary_edges=int(np.count_nonzero(uses == 1)),
        nonmanifold_edges=int(np.count_nonzero(uses > 2)),
        flat_faces=_count_flat(vertices, mesh.faces),
        uvs=len(mesh.uv),
        flat_uv_faces=_count_flat(mesh.uv, mesh.face_uv),
        uv_outside=int(np.count_nonzero(outside[mesh.face_uv].any(axis=1))),
        texture_used=used / counts.size if counts.size else 0.0,
        texture_overlap=int(np.count_nonzero(counts > 1)) / used if used else 0.0,
        texture_sizes=tuple(texture.dimensions() for texture in mesh.textures),
        has_colors=mesh.colors is not None,
        welded_vertices=tidied.welded,
        unused_vertices=tidied.unused,
        collapsed_faces=tidied.collapsed,
        repeated_faces=tidied.repeated,
        facing_away_faces=tidied.facing_away,
        untextured_faces=tidied.untextured,
    )


def _edge_uses(vertex_count: int, faces: np.ndarray) -> np.ndarray:
    """How many faces each edge has."""
    tails, heads = faces.T.ravel(), faces[:, [1, 2, 0]].T.ravel()
    keys = np.sort(np.minimum(tails, heads).astype(np.int64) * vertex_count + np.maximum(tails, heads))
    starts = np.flatnonzero(np.concatenate([[True], keys[1:] != keys[:-1], [True]]))
    return np.diff(starts)


def _count_flat(points: np.ndarray, faces: np.ndarray) -> int:
    """Triangles of points in the plane or in space that have no area, up to rounding."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    sides = [b - a, c - b, a - c]
    longest = np.max([np.einsum("ij,ij->i", side, side) for side in sides], axis=0)
    u, v = sides[0], sides[1]
    axes = [(0, 1)] if points.shape[1] == 2 else [(0, 1), (1, 2), (2, 0)]
    squared = sum((u[:, i] * v[:, j] - u[:, j] * v[:, i]) ** 2 for i, j in axes)
    return int(np.count_nonzero(squared <= (_FLAT * longest) ** 2))
