"""Mid-blends of registered captures: edge lengths and volume against both ends, for every blend.

Starts 0, 16, 32, ... below 175 - gap; the target is aligned on the floor plane by vertex correspondence (centroid and
yaw); means over starts of sqrt(sum (e - e0)^2 / sum e0^2) over edges, e0 the mean of the end lengths, and of
|V / V0 - 1|, V0 the mean of the end volumes. The cage is built on frame 0 and carried to the other frames by soft-held
volumetric ARAP. Beside them the blend's time a frame and, on identical tets and held vertices, our as-rigid-as-possible
solver and libigl's.

    UMG_CAPTURES=FOLDER python benchmarks/blending.py [--quick] [--json FILE]
"""

import argparse
import json
import sys
import time
from pathlib import Path

import igl
import numpy as np
import scipy.sparse as sp

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from real_captures import real_capture

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.arap import HeldArap, arap_energy, arap_forces, arap_stiffness
from unstructured_mg.geometry.rotations import fit_planar, fit_rigid, fit_rotations
from unstructured_mg.geometry.solver import SymmetricSolver
from unstructured_mg.geometry.tets import deformation_gradients, tet_gradients, tet_volumes
from unstructured_mg.synthesis.align import vertex_areas
from unstructured_mg.synthesis.blend import BLENDS, Template
from unstructured_mg.synthesis.posture import Posture
from unstructured_mg.synthesis.quality import volume
from unstructured_mg.tracking.cage import Cage, build_cage
from unstructured_mg.tracking.options import TrackingOptions

FRAMES = 175
# Edge-length error and volume error (share) to be reached 16 frames apart.
REACH = {"mit_crane": (0.0105, 0.0060), "mit_samba": (0.0125, 0.0120)}


def registered(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (175, n, 3) in metres, z up, and faces of a registered capture."""
    (file,) = real_capture(name, ":", "--npz").glob("*.npz")
    with np.load(file) as arrays:
        # y up to z up.
        vertices = arrays["vertices"].astype(np.float64)[:, :, [0, 2, 1]] * [1, -1, 1]
        return vertices, arrays["faces"].astype(np.int32)


def template_of(cage: Cage, surfaces: np.ndarray, faces: np.ndarray) -> Template:
    return Template(surfaces[0], faces, cage.vertices, cage.tets, cage.tet_of_vertex, cage.weights, surfaces)


def carry_cage(template: Template, surfaces: np.ndarray, wanted: list[int]) -> dict[int, np.ndarray]:
    """The cage at the wanted frames: ARAP from rest, surface vertices hold their cells softly; every fourth."""
    areas = vertex_areas(template.surface, template.faces)
    rows = np.repeat(np.arange(len(template.surface)), 4)
    columns = template.tets[template.tet_of_vertex].ravel()
    shape = (len(template.surface), len(template.cage))
    embedding = sp.csr_matrix((template.weights.ravel(), (rows, columns)), shape)
    gradients = tet_gradients(template.cage, template.tets)
    volumes = tet_volumes(template.cage, template.tets)
    held = 100.0 * embedding.T @ sp.diags(areas)
    solver = SymmetricSolver(arap_stiffness(template.cage, template.tets) + held @ embedding)
    rest_residual = template.surface - embedding @ template.cage
    cage, last, found = template.cage, template.surface, {}
    for frame in range(0, max(wanted) + 1, 4):
        rotation, shift = fit_rigid(last, surfaces[frame], areas)
        cage, last = cage @ rotation.T + shift, surfaces[frame]
        for _ in range(6):
            turns = fit_rotations(deformation_gradients(cage, template.tets, gradients))
            carried = np.einsum("nab,nb->na", turns[template.tet_of_vertex], rest_residual)
            forces = arap_forces(len(cage), template.tets, gradients, volumes, turns)
            cage = solver.solve(forces + held @ (surfaces[frame] - carried))
        found[frame] = cage
    return found


def errors(
    shape: np.ndarray, source: np.ndarray, target: np.ndarray, faces: np.ndarray, edges: np.ndarray
) -> tuple[float, float]:
    """Edge-length error and volume error of a mid-blend."""

    def lengths(vertices: np.ndarray) -> np.ndarray:
        return np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)

    expected = (lengths(source) + lengths(target)) / 2
    edge = np.sqrt(((lengths(shape) - expected) ** 2).sum() / (expected**2).sum())
    volumes = [volume(v, faces) for v in (shape, source, target)]
    return float(edge), abs(2 * volumes[0] / (volumes[1] + volumes[2]) - 1)


def compare_blends(name: str, gaps: list[int], stride: int) -> list[dict]:
    surfaces, faces = registered(name)
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    cage = build_cage(TexturedMesh(surfaces[0], faces), TrackingOptions())
    template = template_of(cage, surfaces, faces)
    starts = {gap: list(range(0, FRAMES - gap, stride)) for gap in gaps}
    cages = carry_cage(template, surfaces, sorted({s + d for gap in gaps for s in starts[gap] for d in (0, gap)}))
    print(f"{name}: {len(surfaces[0])} vertices, cage of {len(cage.vertices)} vertices and {len(cage.tets)} tets")
    print(f"{'blend':16} {'gap':>4} {'edges':>8} {'volume':>8} {'inverted':>9} {'ms':>6}")
    figures = []
    for blend_name, make in BLENDS.items():
        blend = make(template)
        for gap in gaps:
            scores, inverted, seconds = [], 0, 0.0
            for start in starts[gap]:
                motion = fit_planar(surfaces[start + gap], surfaces[start], np.ones(len(surfaces[0])))
                source = Posture(surfaces[start], cages[start])
                target = Posture(motion.apply(surfaces[start + gap]), motion.apply(cages[start + gap]))
                begin = time.process_time()
                middle = blend(source, target, 0.5)
                seconds += time.process_time() - begin
                scores.append(errors(middle.surface, source.surface, target.surface, faces, edges))
                if middle.cage is not None:
                    sound = np.min([tet_volumes(c, cage.tets) for c in (source.cage, target.cage)], axis=0) > 0
                    inverted += int((sound & (tet_volumes(middle.cage, cage.tets) <= 0)).sum())
            edge, drift = np.mean(scores, axis=0)
            each = 1000 * seconds / len(starts[gap])
            print(f"{blend_name:16} {gap:4} {edge:8.4f} {drift:8.2%} {inverted:9} {each:6.0f}")
            judged = blend_name == "volumetric_arap" and gap == 16
            reach = REACH[name] if judged else (None, None)
            title = f"{name}, {blend_name}, gap {gap}"
            figures += [
                figure(f"{title}: edge lengths", edge, "rms share", reach[0]),
                figure(f"{title}: volume", float(drift), "share", reach[1]),
            ]
            if judged:
                figures.append(figure(f"{title}: inverted tets", inverted, "cells", 0))
    return figures


def compare_solvers(name: str) -> list[dict]:
    """20 iterations from one start on the same tets with the same held vertices: ours beside libigl's."""
    surfaces, faces = registered(name)
    cage = build_cage(TexturedMesh(surfaces[0], faces), TrackingOptions())
    template = template_of(cage, surfaces, faces)
    start = carry_cage(template, surfaces, [32])[32]
    held = np.arange(0, len(cage.vertices), 20)
    rest = np.ascontiguousarray(cage.vertices)
    initial = rest.copy()
    initial[held] = start[held]
    solver = HeldArap(rest, cage.tets, held)
    begin = time.process_time()
    ours = solver.solve(initial, 20)
    our_time = time.process_time() - begin
    data = igl.ARAPData()
    data.energy = igl.ARAP_ENERGY_TYPE_ELEMENTS
    data.max_iter = 20
    igl.arap_precomputation(rest, cage.tets, 3, held, data)
    begin = time.process_time()
    theirs = igl.arap_solve(initial[held], data, initial)
    their_time = time.process_time() - begin
    energies = [arap_energy(rest, cage.tets, v) for v in (ours, theirs)]
    print(f"{name}: energy after 20 iterations {energies[0]:.6g} against libigl's {energies[1]:.6g}", end="; ")
    print(f"{50 * our_time:.1f} ms an iteration against {50 * their_time:.1f}")
    return [
        figure(f"{name}: ARAP energy over libigl's", energies[0] / energies[1], "ratio", 1.001),
        figure(f"{name}: ARAP time over libigl's", our_time / their_time, "ratio", 1.0),
    ]


def figure(name: str, value: float, unit: str, reach: float | None) -> dict:
    """One figure; smaller is better."""
    holds = None if reach is None else bool(value <= reach)
    return {"name": name, "value": float(value), "unit": unit, "reach": reach, "holds": holds}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="gap 16 only, every third start: under a minute")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    arguments = parser.parse_args()
    gaps, stride = ([16], 48) if arguments.quick else ([8, 16, 32], 16)
    figures = []
    for name in REACH:
        figures += compare_blends(name, gaps, stride) + compare_solvers(name)
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
