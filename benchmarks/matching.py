"""Seconds, accuracy and memory of matching (P section 4, A.1), against plain ways to get the same.

Descriptors: of a figure of as many faces as the papers' captures have; the peer voxelises the surface, takes SciPy's
exact transform of the voxels and looks it up on the cylinder. Pairs: of all frames; the peer multiplies, sums,
windows and transforms pair by pair, as the paper describes it, for a sample of pairs and is scaled up. The
coefficients for the pairs are those of a short motion, repeated over and over: the work does not depend on what is in
them. Yaw: of a figure turned at random, re-meshed in every frame.

    OPENBLAS_NUM_THREADS=1 python benchmarks/matching.py [--quick] [--workers 2] [--json FILE]
"""

import argparse
import json
import multiprocessing
import resource
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.fft
import scipy.ndimage
import trimesh

from unstructured_mg.capture.capture import Capture, FrameFile
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.matching import cylindrical_edt
from unstructured_mg.matching.dissimilarity import compare_windows, compute_dissimilarity
from unstructured_mg.matching.fields import Fields
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.matching.window import window_weights

RESOLUTION, K = 64, 10


def body(phase: float, yaw: float, seed: int, level: int) -> TexturedMesh:
    """A figure of ellipsoids; ``level`` 3, 4, 5: 9k, 36k, 143k faces. Another mesh for every seed."""
    random = np.random.default_rng(seed)
    swing = 0.5 * np.sin(phase)
    vertices, faces, count = [], [], 0
    for joint, axes, angle, hang in (
        ((0, 0, 1.15), (0.13, 0.19, 0.33), 0.0, 0.0),
        ((0, 0, 1.65), (0.11, 0.09, 0.14), 0.0, 0.0),
        ((0.12, 0, 1.63), (0.04, 0.03, 0.03), 0.0, 0.0),
        ((0, 0.24, 1.4), (0.05, 0.05, 0.32), swing, 1.0),
        ((0, -0.24, 1.4), (0.05, 0.05, 0.32), -swing - 0.6, 1.0),
        ((0, 0.1, 0.9), (0.08, 0.08, 0.45), -swing, 1.0),
        ((0, -0.1, 0.9), (0.08, 0.08, 0.45), swing, 1.0),
    ):
        ball = trimesh.creation.icosphere(level)
        points = ball.vertices @ trimesh.transformations.random_rotation_matrix(random.random(3))[:3, :3].T
        points = points * axes - [0, 0, hang * axes[2]]
        c, s = np.cos(angle), np.sin(angle)
        vertices.append(points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T + joint)
        faces.append(ball.faces + count)
        count += len(points)
    c, s = np.cos(yaw), np.sin(yaw)
    turned = np.concatenate(vertices) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    return TexturedMesh(turned, np.concatenate(faces).astype(np.int32))


@dataclass(frozen=True)
class BodyCapture(Capture):
    """Frames made on demand: a clip to be matched, and others of the same motion, each turned by a yaw of its own."""

    turns: tuple[float, ...] = ()

    def read(self, index: int) -> TexturedMesh:
        clip, number = divmod(index, 2 * K + 1)
        return body(0.1 * number, self.turns[clip], index, 3)


def descriptor_times(level: int, repeats: int) -> tuple[int, float, float]:
    """Faces, and seconds a frame: ours and the peer's; the least of the repeats."""
    meshes = [body(0.3 * i, 0.0, i, level) for i in range(repeats)]
    ours, peer = [], []
    for mesh in meshes:
        began = time.perf_counter()
        extent = cylindrical_edt.extent(mesh)
        cylinder = cylindrical_edt.fit(extent[None], RESOLUTION)
        cylindrical_edt.describe(mesh, extent, cylinder)
        ours.append(time.perf_counter() - began)
        began = time.perf_counter()
        voxel_descriptor(mesh, extent, cylinder)
        peer.append(time.perf_counter() - began)
    return len(meshes[0].faces), min(ours), min(peer)


def voxel_descriptor(
    mesh: TexturedMesh, extent: np.ndarray, cylinder: cylindrical_edt.Cylinder
) -> tuple[np.ndarray, np.ndarray]:
    """The same two fields from voxels as fine as the finer of the cylinder's steps."""
    size = min(cylinder.radius_step, cylinder.height_step)
    low = np.array([extent[0] - extent[2], extent[1] - extent[2], cylinder.bottom]) - 2 * size
    counts = np.ceil(
        (2 * extent[2] / size + 4, 2 * extent[2] / size + 4, cylinder.heights * cylinder.height_step / size + 4)
    ).astype(int)
    samples = mesh.vertices[mesh.faces].mean(axis=1)
    cells = np.clip(((samples - low) / size).astype(int), 0, counts - 1)
    empty = np.ones(counts, bool)
    empty[tuple(cells.T)] = False
    square = scipy.ndimage.distance_transform_edt(empty, sampling=size) ** 2
    radius = (np.arange(cylinder.radii) + 0.5)[:, None, None] * cylinder.radius_step
    height = (cylinder.bottom + np.arange(cylinder.heights) * cylinder.height_step)[None, :, None]
    angle = 2 * np.pi * np.arange(cylinder.angles) / cylinder.angles
    points = np.stack(np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), height))
    places = (points + [[[[extent[0]]]], [[[extent[1]]]], [[[0.0]]]] - low[:, None, None, None]) / size - 0.5
    on_cylinder = scipy.ndimage.map_coordinates(square, places, order=1, mode="nearest", output=np.float32)
    surface = scipy.ndimage.map_coordinates((~empty).astype(np.float32), places, order=1, mode="nearest")
    return scipy.fft.rfft(surface), scipy.fft.rfft(on_cylinder)


def yaw_error(scratch: Path) -> tuple[float, float]:
    """Over twelve random turns, the largest error in degrees and score, in metres, of a motion against itself."""
    turns = (0.0, *np.random.default_rng(0).uniform(-np.pi, np.pi, 12))
    size = 2 * K + 1
    frames = tuple(FrameFile(f"clip {clip}", i, Path()) for clip in range(13) for i in range(size))
    capture = BodyCapture(Path(), frames, 30.0, 1.0, "z", 0.0, turns=turns)
    found = compute_dissimilarity(capture, MatchingOptions(), scratch=scratch)
    centres = size * np.arange(1, 13) + K
    error = (found.yaw[K, centres] + turns[1:] + np.pi) % (2 * np.pi) - np.pi
    return float(np.degrees(np.abs(error)).max()), float(found.scores[K, centres].max())


def repeated_fields(folder: Path, frames: int) -> Fields:
    """Coefficients of a 32-frame motion over and over, on disk."""
    frequencies, cells, _ = cylindrical_edt.shape(RESOLUTION)
    fields = Fields(folder, frames, frequencies, cells)
    meshes = [body(0.2 * i, 0.0, i, 3) for i in range(len(fields.blocks()[0]))]
    extents = np.stack([cylindrical_edt.extent(mesh) for mesh in meshes])
    cylinder = cylindrical_edt.fit(extents, RESOLUTION)
    described = [cylindrical_edt.describe(mesh, e, cylinder)[:2] for mesh, e in zip(meshes, extents, strict=True)]
    stacked = np.stack([np.stack(pair) for pair in described], axis=2)
    for block in fields.blocks():
        fields.write(block, np.ascontiguousarray(stacked[:, :, : len(block)]))
    return fields


def pair_by_pair(fields: Fields, pairs: int) -> float:
    """Seconds a pair where nothing is shared between pairs but the window."""
    frequencies = range(fields.frequencies)
    left, right = (np.stack([fields.read(f, m, 0, pairs + 2 * K) for m in frequencies], axis=1) for f in (0, 1))
    weights, best = window_weights(K), []
    began = time.perf_counter()
    products = np.stack(
        [
            np.einsum("fc,fc->f", left[0], right[i]) + np.einsum("fc,fc->f", right[0], left[i]).conj()
            for i in range(pairs + 2 * K)
        ]
    )
    for i in range(pairs):
        series = weights @ products[i : i + 2 * K + 1]
        best.append(scipy.fft.irfft(series, n=2 * RESOLUTION).min())
    return (time.perf_counter() - began) / pairs


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="pairs of 350 frames only")
    parser.add_argument("--workers", type=int, default=2, help="processes that compare pairs")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    arguments = parser.parse_args()
    figures = []

    def add(name: str, value: float, unit: str, reach: float | None = None, most: bool = True) -> None:
        holds = None if reach is None else bool(value <= reach if most else value >= reach)
        figures.append({"name": name, "value": float(value), "unit": unit, "reach": reach, "holds": holds})
        print(f"{name}: {value:.4g} {unit} (reach {reach}, holds: {holds})", flush=True)

    for level in (3, 4) if arguments.quick else (3, 4, 5):
        faces, ours, peer = descriptor_times(level, 8)
        add(f"descriptor, {faces} faces", 1e3 * ours, "ms a frame", 60e3 * arguments.workers / 2283)
        add(f"descriptor, {faces} faces, times faster than voxels", peer / ours, "x")
    with tempfile.TemporaryDirectory() as folder:
        error, score = yaw_error(Path(folder))
    add("yaw error, largest of 12 re-meshed turns", error, "degrees", 1.0)
    add("score of a motion against itself, re-meshed and turned, largest", 1e3 * score, "mm")
    context = multiprocessing.get_context("spawn")
    for frames in (350,) if arguments.quick else (350, 1000, 2283):
        with tempfile.TemporaryDirectory() as folder:
            fields, zeros = repeated_fields(Path(folder), frames), np.zeros(frames)
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            with ProcessPoolExecutor(arguments.workers, context) as executor:
                list(executor.map(abs, range(8 * arguments.workers)))  # the workers are there
                began = time.perf_counter()
                compare_windows(fields, 2 * RESOLUTION, zeros, zeros + 0j, K, executor=executor)
                seconds = time.perf_counter() - began
            processor = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
            peer = pair_by_pair(fields, 150) * (frames - 2 * K) ** 2 / 2
        add(f"all pairs of {frames} frames", seconds, "s", 60.0 * (frames / 2283) ** 2)
        add(f"all pairs of {frames} frames, processor time of all workers", processor, "s")
        add(f"all pairs of {frames} frames, times faster than pair by pair on one core", peer / seconds, "x")
    units = 2**30 if sys.platform == "darwin" else 2**20
    here, worker = (
        resource.getrusage(who).ru_maxrss / units for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    add("memory, largest worker", worker, "GiB", 2.0)
    add("memory, all processes, at most", here + arguments.workers * worker, "GiB", 4.0)
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
