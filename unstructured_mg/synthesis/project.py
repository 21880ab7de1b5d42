"""Project a captured frame's colours onto the tracked template (P section 6.2)."""

import numpy as np

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.agreeing import AgreeingPoints
from unstructured_mg.geometry.normals import vertex_normals
from unstructured_mg.synthesis.images import Image, sample


def project_colors(
    mesh: TexturedMesh,
    images: list[Image],
    points: np.ndarray,
    normals: np.ndarray,
    reach: float,
    agreement: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Colours of surface points from the nearest captured surface that looks the same way.

    Parameters
    ----------
    mesh, images : the captured frame and its decoded images (none: its vertex colours are taken)
    points, normals : (p, 3) float64, metres; neighbours in order should be neighbours in space
    reach : metres; farther surface does not count
    agreement : least cosine between normals

    Returns
    -------
    colors : (p, 3) float32, sRGB 0..255, anything where not seen
    seen : (p,) bool
    """
    face, weights, _ = AgreeingPoints(mesh.vertices, mesh.faces).query(points, normals, reach, agreement)
    seen = face >= 0
    colors = np.zeros((len(points), 3), np.float32)
    if not images:
        if mesh.colors is None:
            raise ValueError("mesh: expected vertex colours where there are no images")
        corners = mesh.colors[mesh.faces[face[seen]]].astype(np.float64)
        colors[seen] = np.einsum("pi,pic->pc", weights[seen], corners)
        return colors, seen
    for material, image in enumerate(images):
        mine = seen if mesh.face_material is None else seen & (mesh.face_material[face] == material)
        corners = mesh.uv[mesh.face_uv[face[mine]]]
        colors[mine] = sample(image, np.einsum("pi,pic->pc", weights[mine], corners))
    return colors, seen


def smooth_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit vertex normals (n, 3); where they cancel the x axis, which then hardly agrees with anything."""
    normals = vertex_normals(vertices, faces)
    normals[~normals.any(axis=1)] = (1.0, 0.0, 0.0)
    return normals
