"""Writing one OBJ frame: the .obj and, where it has a texture, its .mtl."""

from pathlib import Path

import numpy as np


def write_obj(
    path: Path,
    vertices: np.ndarray,
    faces: np.ndarray,
    uv: np.ndarray,
    face_uv: np.ndarray,
    images: tuple[str, ...] = (),
    face_material: np.ndarray | None = None,
    colors: np.ndarray | None = None,
) -> None:
    """Write ``path`` (ends in .obj) and, where ``images`` are given, a .mtl of the same stem beside it.

    Arrays as in TexturedMesh, but in the file's own unit and axis. ``images`` are file names relative to ``path``, one
    a material; ``face_material`` (m,) int32 says which face has which. ``colors`` (n, 3) uint8 become
    ``v x y z r g b``. Seven significant decimals below the unit are kept: 1e-7 of a metre where the unit is a metre.
    """
    lines = []
    if images:
        lines.append(f"mtllib {path.stem}.mtl\n")
    if colors is None:
        lines.append(_rows("v %.7f %.7f %.7f\n", vertices))
    else:
        lines.append(_rows("v %.7f %.7f %.7f %.4f %.4f %.4f\n", np.column_stack([vertices, colors / 255.0])))
    has_uv = len(face_uv) > 0
    if has_uv:
        lines.append(_rows("vt %.7f %.7f\n", uv))
        corners = np.stack([faces, face_uv], axis=2).reshape(-1, 6) + 1
        pattern = "f %d/%d %d/%d %d/%d\n"
    else:
        corners, pattern = faces + 1, "f %d %d %d\n"
    if len(images) > 1 and face_material is not None:
        for material in range(len(images)):
            lines.append(f"usemtl material_{material}\n")
            lines.append(_rows(pattern, corners[face_material == material]))
    else:
        if images:
            lines.append("usemtl material_0\n")
        lines.append(_rows(pattern, corners))
    path.write_text("".join(lines))
    if images:
        materials = (f"newmtl material_{i}\nKd 1 1 1\nmap_Kd {name}\n" for i, name in enumerate(images))
        path.with_suffix(".mtl").write_text("".join(materials))


def _rows(pattern: str, rows: np.ndarray) -> str:
    return (pattern * len(rows)) % tuple(rows.ravel().tolist())
