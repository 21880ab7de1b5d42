"""A tet cage by fTetWild (pytetwild): closer to the body, not repeatable from run to run."""

import subprocess
import sys
import tempfile
from pathlib import Path

import igl
import numpy as np
import pyvista

from unstructured_mg.geometry.closest import ClosestPoints
from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.tracking.embedding import Cage, make_cage
from unstructured_mg.tracking.surface import CleanSurface

_CHILD = """
import sys
import numpy as np
import pytetwild
given = np.load(sys.argv[1])
vertices, tets = pytetwild.tetrahedralize(
    given["vertices"], given["faces"], edge_length_fac=float(sys.argv[3]), epsilon=float(sys.argv[4]), optimize=True
)[:2]
np.savez(sys.argv[2], vertices=np.asarray(vertices, np.float64), tets=np.asarray(tets, np.int32))
"""


def tetwild_cage(surface: CleanSurface, goal: int, seconds: float) -> Cage:
    """A cage with about ``goal`` vertices; RuntimeError where the child fails or exceeds ``seconds``.

    pytetwild may hang and writes stray files, so it runs in a child process with a folder of its own; its tets may come
    negatively oriented, which is mended here.
    """
    faces = surface.faces[surface.geometric]
    decimated, decimated_faces = _decimate(surface.vertices, faces, max(600, 2 * goal))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savez(folder / "given.npz", vertices=decimated, faces=decimated_faces)
        command = [sys.executable, "-c", _CHILD, "given.npz", "made.npz", "0.06", "0.003"]
        try:
            done = subprocess.run(command, cwd=folder, timeout=seconds, capture_output=True, text=True)
        except subprocess.TimeoutExpired as error:
            raise RuntimeError(f"pytetwild did not end within {seconds:g} s") from error
        if done.returncode != 0 or not (folder / "made.npz").exists():
            raise RuntimeError(f"pytetwild failed: {done.stderr.strip()[-300:]}")
        with np.load(folder / "made.npz") as made:
            vertices, tets = made["vertices"], made["tets"]
    volumes = tet_volumes(vertices, tets)
    tets[volumes < 0] = tets[volumes < 0][:, [0, 1, 3, 2]]
    tets = tets[np.abs(volumes) > 1e-9 * np.abs(volumes).max()]
    used, compact = np.unique(tets, return_inverse=True)
    vertices, tets = vertices[used], compact.reshape(-1, 4).astype(np.int32)
    return make_cage(vertices, tets, surface.vertices, _nearest_tets(vertices, tets, surface.vertices), "tetwild")


def _decimate(vertices: np.ndarray, faces: np.ndarray, goal: int) -> tuple[np.ndarray, np.ndarray]:
    if len(faces) <= goal:
        return vertices, faces
    mesh = pyvista.PolyData.from_regular_faces(vertices, faces).decimate(1 - goal / len(faces))
    return np.asarray(mesh.points, np.float64), np.asarray(mesh.regular_faces, np.int32)


def _nearest_tets(vertices: np.ndarray, tets: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The tet (p,) that holds each point, or the boundary tet nearest to it."""
    sides = tets[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]].reshape(-1, 3)
    owner = np.repeat(np.arange(len(tets)), 4)
    _, inverse, count = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    outer = count[inverse.reshape(-1)] == 1
    _, face, _ = ClosestPoints(vertices, sides[outer].astype(np.int32)).query(points)
    nearest = owner[outer][face]
    tree = igl.AABB()
    tree.init(vertices, tets.astype(np.int64))
    holding = np.ravel(igl.in_element(vertices, tets.astype(np.int64), points, tree))
    return np.where(holding >= 0, holding, nearest).astype(np.int32)
