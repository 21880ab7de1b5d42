"""A captured frame with fewer faces."""

from dataclasses import replace

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.decimate import Decimation, decimate


def decimated_mesh(mesh: TexturedMesh, goal: int) -> TexturedMesh:
    """The mesh with about ``goal`` faces on the same texture; as it is where it has no more. See `decimate`."""
    if len(mesh.faces) <= goal:
        return mesh
    return apply_decimation(mesh, decimate(mesh.vertices, mesh.faces, goal, mesh.uv, mesh.face_uv, mesh.face_material))


def apply_decimation(mesh: TexturedMesh, found: Decimation) -> TexturedMesh:
    """What a decimation leaves of a mesh with the connectivity that it was made for."""
    return replace(
        mesh,
        vertices=mesh.vertices[found.vertex_index],
        faces=found.faces,
        uv=mesh.uv[found.uv_index],
        face_uv=found.face_uv,
        colors=None if mesh.colors is None else mesh.colors[found.vertex_index],
        face_material=None if mesh.face_material is None else mesh.face_material[found.face_index],
    )
