"""Seconds, accuracy and memory of matching (P section 4, A.1; H section 3.1; B section 3.1), against plain ways.

Descriptors: of a figure of as many faces as the papers' captures have; the peer voxelises the surface, takes SciPy's
exact transform of the voxels and looks it up on the cylinder. Pairs: of all frames; the peer multiplies, sums, windows
and transforms pair by pair, as the paper describes it, for a sample of pairs and is scaled up. The coefficients for the
pairs are those of a short motion, repeated over and over: the work does not depend on what is in them.

Yaw: of every frame of the registered captures crane and samba against itself, re-meshed and turned at random. ROC: how
well scores tell pairs of windows that are alike from others. Alike are those a twentieth of the pairs (at least a
window apart) whose true distance is least: the root mean square distance between corresponding vertices over the
window, after the one turn and shift on the floor that makes it least. Corresponding vertices are known to the truth
and, by its connectivity, to deformation gradients; the other descriptors see every frame re-meshed. For the colour term
the figures wear a pattern. These need UMG_CAPTURES.

    OPENBLAS_NUM_THREADS=1 UMG_CAPTURES=FOLDER python benchmarks/matching.py [--quick] [--workers 2] [--json FILE]
"""

import argparse
import json
import multiprocessing
import os
import resource
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import scipy.fft
import scipy.ndimage
from scipy.stats import rankdata

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from array_capture import array_capture, figure
from real_captures import real_capture
from toy_capture import ToyCapture, toy_capture

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.capture.procedural.remesh import coarsen, opposite_half_edges
from unstructured_mg.geometry.laplacian import face_areas
from unstructured_mg.matching import cylindrical_edt
from unstructured_mg.matching.descriptor import Window
from unstructured_mg.matching.descriptors import DESCRIPTORS
from unstructured_mg.matching.dissimilarity import Described, compare_windows, describe_frames
from unstructured_mg.matching.extent import extent
from unstructured_mg.matching.fields import Fields
from unstructured_mg.matching.options import MatchingOptions
from unstructured_mg.matching.window import spline_weights

RESOLUTION, K = 64, 10
CAPTURES = ("mit_crane", "mit_samba")
ALIKE = 0.05
# Scores that the ROC compares: descriptor and options that are not the default ones.
SCORES: tuple[tuple[str, dict[str, float]], ...] = (
    ("cylindrical_edt", {}),
    ("cylindrical_edt", {"velocity_seconds": 0.0}),
    ("cylindrical_edt", {"velocity_seconds": 0.2}),
    ("cylindrical_edt", {"colour_m": 0.05}),
    ("cylindrical_edt", {"colour_m": 0.1}),
    ("shape_histogram", {}),
    ("shape_histogram", {"velocity_seconds": 0.0}),
    ("deformation_gradients", {}),
    ("deformation_gradients", {"velocity_seconds": 0.0}),
)


def descriptor_times(name: str, level: int, repeats: int) -> tuple[int, float, float]:
    """Faces, and processor seconds a frame: ours and, of the cylinder, the peer's; the least of the repeats."""
    capture = array_capture([figure(0.3 * i, seed=i, level=level) for i in range(repeats)])
    if name == "deformation_gradients":
        one = figure(0.0, seed=0, level=level)
        capture = array_capture([one] * repeats)
    descriptor = DESCRIPTORS[name]
    ours, peer = [], [np.inf]
    for index in range(repeats):
        mesh = capture.read(index)
        place = extent(mesh)
        layout = descriptor.fit(capture, place[None], descriptor.resolution, 0.0)
        began = time.process_time()
        place = extent(mesh)
        descriptor.describe(capture, index, place, layout)
        ours.append(time.process_time() - began)
        if name == "cylindrical_edt":
            began = time.process_time()
            voxel_descriptor(mesh, place, layout)
            peer.append(time.process_time() - began)
    return len(capture.read(0).faces), min(ours), min(peer)


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


def registered(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (frames, n, 3) of a registered capture, in metres, z up, and faces."""
    (file,) = real_capture(name, ":", "--npz").glob("*.npz")
    with np.load(file) as arrays:
        vertices = arrays["vertices"].astype(np.float64)[:, :, [0, 2, 1]] * [1, -1, 1]
        return vertices, arrays["faces"].astype(np.int32)


def remeshed(vertices: np.ndarray, faces: np.ndarray, colours: np.ndarray | None, seed: int) -> TexturedMesh:
    """A frame with seven tenths of its faces left after random collapses, and another order of what is left."""
    opposite, random = opposite_half_edges(faces), np.random.default_rng(seed)
    sizes = np.full(len(vertices), 0.015)
    kept, coarse = coarsen(faces, opposite, vertices, sizes, seed, 7 * len(faces) // 10)
    order = random.permutation(len(kept))
    place = np.empty(len(kept), np.int32)
    place[order] = np.arange(len(kept))
    return TexturedMesh(
        vertices[kept[order]],
        random.permutation(place[coarse]),
        colors=None if colours is None else colours[kept[order]],
    )


def pattern(vertices: np.ndarray) -> np.ndarray:
    """Vertex colours (n, 3) uint8 for a first frame: each channel a wave through the body."""
    waves = np.array([[9.0, 4.0, 5.0], [-5.0, 8.0, 7.0], [4.0, -7.0, 11.0]])
    return np.rint(127.5 + 127.5 * np.sin(vertices @ waves.T)).astype(np.uint8)


def capture_of(name: str, connectivity: bool) -> ToyCapture:
    """A registered capture, its frames re-meshed on demand, or as they are where ``connectivity`` is to be kept."""
    vertices, faces = registered(name)
    colours = pattern(vertices[0])

    def mesh(index: int) -> TexturedMesh:
        return (
            TexturedMesh(vertices[index], faces) if connectivity else remeshed(vertices[index], faces, colours, index)
        )

    return toy_capture(len(vertices), mesh_of=mesh)


def true_distances(name: str, k: int) -> np.ndarray:
    """``(n, n)``: metres between corresponding vertices of two windows, after one best motion on the floor."""
    vertices, faces = registered(name)
    corner = np.repeat(face_areas(vertices[0], faces) / 3, 3)
    mass = np.bincount(faces.ravel(), corner, len(vertices[0]))
    mass /= mass.sum()
    z, height = vertices[..., 0] + 1j * vertices[..., 1], vertices[..., 2]
    n, weights = len(vertices), spline_weights(k)
    inside = slice(k, n - k)

    def windowed(values: np.ndarray) -> np.ndarray:
        shape = values.shape[1:]
        total = np.full(values.shape, np.nan, values.dtype)
        sums = sum(
            w * (values[at : n - 2 * k + at] if not shape else values[at : n - 2 * k + at, at : n - 2 * k + at])
            for at, w in enumerate(weights)
        )
        total[inside if not shape else (inside, inside)] = sums
        return total

    moment = windowed((np.abs(z) ** 2) @ mass)
    centre = windowed(z @ mass)
    cross = windowed((z * mass) @ z.conj().T) - centre[:, None] * centre.conj()
    up = (height * mass) @ height.T
    levels = windowed(np.diag(up)[:, None] + np.diag(up) - 2 * up)
    spread = moment - np.abs(centre) ** 2
    return np.sqrt(np.maximum(spread[:, None] + spread - 2 * np.abs(cross) + levels, 0))


def roc(scores: np.ndarray, alike: np.ndarray) -> tuple[float, float]:
    """Area under the curve, and share of the alike found where a twentieth of the others are."""
    ranks = rankdata(scores)
    positives, negatives = int(alike.sum()), int((~alike).sum())
    area = 1 - (ranks[alike].sum() - positives * (positives + 1) / 2) / (positives * negatives)
    return float(area), float((scores[alike] <= np.quantile(scores[~alike], 0.05)).mean())


def roc_figures(add, names: tuple[str, ...]) -> None:
    """The ROC of every score, and the score of pairs that are as far apart as the default threshold."""
    for name in names:
        truth = true_distances(name, K)
        described: dict[tuple[str, float], Described] = {}
        for descriptor, change in SCORES:
            options = MatchingOptions(descriptor=descriptor, **change)
            capture = capture_of(name, descriptor == "deformation_gradients")
            key = (descriptor, options.colour_m)
            if key not in described:
                folder = Path(tempfile.mkdtemp())
                described[key] = describe_frames(capture, options, scratch=folder)
            found = compare_windows(capture, described[key], options)
            index = np.arange(len(truth))
            chosen = np.isfinite(found.scores) & (index - index[:, None] >= 2 * K + 1)
            scores, true = found.scores[chosen], truth[chosen]
            area, hits = roc(scores, true <= np.quantile(true, ALIKE))
            label = " ".join([descriptor, *(f"{word} {value:g}" for word, value in change.items())])
            add(f"{name}, {label}: area under the ROC", area, "")
            add(f"{name}, {label}: found at 5 % false alarms", 100 * hits, "%")
            limit = DESCRIPTORS["cylindrical_edt"].threshold * found.size
            near = np.abs(true / limit - 1) < 0.1
            if not change and near.any():
                add(
                    f"{name}, {label}: median score at a true distance of {1e3 * limit:.0f} mm",
                    np.median(scores[near]),
                    found.unit,
                )
        for each in described.values():
            each.fields.remove()
            each.fields.folder.rmdir()


def yaw_figures(add, descriptors: tuple[str, ...], step: int) -> None:
    """Every ``step``-th frame of both captures against itself, re-meshed and turned: single frames, no window."""
    meshes, turns, random = [], [], np.random.default_rng(0)
    for name in CAPTURES:
        vertices, faces = registered(name)
        for index in range(0, len(vertices), step):
            turns.append(random.uniform(-np.pi, np.pi))
            c, s = np.cos(turns[-1]), np.sin(turns[-1])
            other = remeshed(vertices[index], faces, None, index)
            turned = other.vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + [1.0, -2.0, 0.0]
            meshes += [(vertices[index], faces), (turned, other.faces)]
    count = len(turns)
    capture = array_capture(meshes[::2] + meshes[1::2], clips=[("as it is", range(count)), ("turned", range(count))])
    for descriptor in descriptors:
        with tempfile.TemporaryDirectory() as folder:
            described = describe_frames(capture, MatchingOptions(descriptor=descriptor), scratch=Path(folder))
            window = Window(0, np.ones(1), np.zeros(2 * count, complex))
            compared = DESCRIPTORS[descriptor].compare(
                described.fields, described.layout, described.own, range(count), range(count, 2 * count), (window,)
            )
        yaw = np.diagonal(compared[0][1])
        error = np.degrees(np.abs((yaw + turns + np.pi) % (2 * np.pi) - np.pi))
        label = f"{descriptor}, {count} frames re-meshed and turned"
        add(f"{label}: yaw error, largest", error.max(), "degrees", 1.0)
        add(f"{label}: yaw error, median", np.median(error), "degrees")


def repeated_fields(folder: Path, frames: int) -> Fields:
    """Coefficients of a 32-frame motion over and over, on disk."""
    capture = array_capture([figure(0.2 * i, seed=i) for i in range(32)])
    extents = np.stack([extent(capture.read(i)) for i in range(32)])
    cylinder = cylindrical_edt.fit(capture, extents, RESOLUTION)
    fields = Fields(folder, frames, *cylindrical_edt.shape(cylinder))
    described = [cylindrical_edt.describe(capture, i, extents[i], cylinder)[0] for i in range(32)]
    stacked = np.stack(described, axis=1)
    for block in fields.blocks():
        fields.write(block, np.ascontiguousarray(stacked[:, : len(block)]))
    return fields


def pair_by_pair(fields: Fields, pairs: int) -> float:
    """Seconds a pair where nothing is shared between pairs but the window."""
    rows = np.stack([fields.read(row, 0, pairs + 2 * K) for row in range(fields.rows)], axis=1)
    left, right = np.split(rows, 2, axis=1)
    weights, best = spline_weights(K), []
    began = time.process_time()
    products = np.stack(
        [
            np.einsum("fc,fc->f", left[0], right[i]) + np.einsum("fc,fc->f", right[0], left[i]).conj()
            for i in range(pairs + 2 * K)
        ]
    )
    for i in range(pairs):
        series = weights @ products[i : i + 2 * K + 1]
        best.append(scipy.fft.irfft(series, n=2 * RESOLUTION).min())
    return (time.process_time() - began) / pairs


def figures_of_pairs(add, frames: int, workers: int) -> None:
    """All pairs of so many frames on so many workers; wall time, and processor time of all of them."""
    context = multiprocessing.get_context("spawn")
    with tempfile.TemporaryDirectory() as folder:
        fields, zeros = repeated_fields(Path(folder), frames), np.zeros(frames)
        described = Described("cylindrical_edt", fields, None, zeros, np.zeros((frames, 2)), 1.8)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        with ProcessPoolExecutor(workers, context) as executor:
            list(executor.map(abs, range(8 * workers)))  # the workers are there
            began = time.perf_counter()
            compare_windows(toy_capture(frames), described, MatchingOptions(), executor=executor)
            seconds = time.perf_counter() - began
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        peer = pair_by_pair(fields, 150) * (frames - 2 * K) ** 2 / 2
    reach = 60.0 if frames == 2283 else None
    add(f"all pairs of {frames} frames", seconds, "s", reach)
    add(
        f"all pairs of {frames} frames, processor time of all workers",
        spent,
        "s",
        60.0 * workers * (frames / 2283) ** 2,
    )
    add(f"all pairs of {frames} frames, times less processor time than pair by pair", peer / spent, "x")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few frames, pairs of 350 only; under a minute")
    parser.add_argument("--only", choices=("speed", "yaw", "roc"), help="one part alone")
    parser.add_argument("--workers", type=int, default=2, help="processes that compare pairs")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    arguments = parser.parse_args()
    figures = []

    def add(name: str, value: float, unit: str, reach: float | None = None) -> None:
        holds = None if reach is None else bool(value <= reach)
        figures.append({"name": name, "value": float(value), "unit": unit, "reach": reach, "holds": holds})
        print(
            f"{name}: {value:.4g} {unit}" + ("" if reach is None else f" (reach {reach:.3g}, holds: {holds})"),
            flush=True,
        )

    if arguments.only in (None, "speed"):
        for name in DESCRIPTORS:
            for level in (3, 4) if arguments.quick else (3, 4, 5):
                faces, ours, peer = descriptor_times(name, level, 6)
                add(f"{name}, {faces} faces", 1e3 * ours, "ms a frame", 60e3 * arguments.workers / 2283)
                if np.isfinite(peer):
                    add(f"{name}, {faces} faces, times faster than voxels", peer / ours, "x")
        for frames in (350,) if arguments.quick else (350, 1000, 2283):
            figures_of_pairs(add, frames, arguments.workers)
        units = 2**30 if sys.platform == "darwin" else 2**20
        here, worker = (
            resource.getrusage(who).ru_maxrss / units for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        )
        add("memory, largest worker", worker, "GiB", 2.0)
        add("memory, all processes, at most", here + arguments.workers * worker, "GiB", 4.0)
    if "UMG_CAPTURES" not in os.environ:
        print("UMG_CAPTURES is not set: no yaw errors and no ROC")
    else:
        if arguments.only in (None, "yaw"):
            yaw_figures(add, ("cylindrical_edt", "shape_histogram"), 25 if arguments.quick else 1)
        if arguments.only in (None, "roc") and not arguments.quick:
            roc_figures(add, CAPTURES)
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main()
