"""The tet cage of a template: built once by the chosen method, stored, and read back."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.array_file import Expected, as_written, read_arrays, read_json
from unstructured_mg.tracking.cage_lattice import lattice_cage
from unstructured_mg.tracking.cage_tetwild import tetwild_cage
from unstructured_mg.tracking.embedding import Cage, make_cage
from unstructured_mg.tracking.options import TrackingOptions
from unstructured_mg.tracking.surface import CleanSurface, clean_surface, face_normals

__all__ = ["Cage", "build_cage", "build_lattice", "read_cage", "write_cage"]


def build_cage(mesh: TexturedMesh, options: TrackingOptions) -> Cage:
    """The cage of a template frame's clean surface (``surface.clean_surface``), by ``options.cage``.

    Raises ValueError for a mesh without area, RuntimeError where pytetwild fails or runs out of time.
    """
    surface = clean_surface(mesh.vertices, mesh.faces, options.debris_share)
    if options.cage == "tetwild":
        return tetwild_cage(surface, options.cage_vertices, options.tetwild_seconds)
    return build_lattice(surface, options.cage_vertices)


def build_lattice(surface: CleanSurface, goal: int) -> Cage:
    """A lattice cage with about ``goal`` vertices: a coarse trial tells how the count goes with the constant."""
    area = 0.5 * np.linalg.norm(face_normals(surface.vertices, surface.faces[surface.geometric]), axis=1).sum()
    constant = 2.0 * np.sqrt(area / goal)
    for _ in range(3):
        vertices, tets, tet_of_vertex = lattice_cage(surface.vertices, surface.faces, constant)
        if 0.8 * goal <= len(vertices) <= 1.25 * goal:
            break
        # Between a thin sheet (exponent 2) and a solid (exponent 3).
        constant *= (len(vertices) / goal) ** (1 / 2.4)
    return make_cage(vertices, tets, surface.vertices, tet_of_vertex, "lattice")


_ARRAYS: dict[str, Expected] = {
    "vertices": ("float64", ("c", 3), None),
    "tets": ("int32", ("q", 4), "c"),
    "tet_of_vertex": ("int32", ("n",), "q"),
    "weights": ("float64", ("n", 4), None),
    "residual": ("float64", ("n", 3), None),
}


def write_cage(cage: Cage, folder: Path) -> None:
    """Write ``cage.npz`` and ``cage.json`` into an existing folder."""
    arrays = {name: getattr(cage, name) for name in ("vertices", "tets", "tet_of_vertex", "weights", "residual")}
    np.savez(folder / "cage.npz", **arrays)
    (folder / "cage.json").write_text(json.dumps({"method": cage.method}))


def read_cage(folder: Path) -> Cage:
    """What ``write_cage`` wrote. Raises UserError where a file is missing or something else."""
    arrays, path = read_arrays(folder / "cage.npz", _ARRAYS), folder / "cage.json"
    content: Any = read_json(path)
    with as_written(path):
        return Cage(**arrays, method=str(content["method"]))
