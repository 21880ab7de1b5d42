"""The template's surface as flow and texels see it: seams welded, sheets separate, long edges split."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from unstructured_mg.geometry.components import weld
from unstructured_mg.geometry.halfedges import match_halfedges, split_fans
from unstructured_mg.geometry.morton import morton_order
from unstructured_mg.geometry.tracing import TracingSurface
from unstructured_mg.synthesis.refine import refine


@dataclass(frozen=True)
class FlowSurface:
    """A refined copy of the template that points can move on.

    Vertices that only an atlas seam keeps apart are one; sheets that touch without being neighbours are apart.

    Attributes
    ----------
    vertices : (n, 3) float64, metres, at the template frame
    tracing : the surface to move on; its ``faces`` (m, 3) index ``vertices``
    uv : (m, 3, 2) float64, every face corner's place in the transition's atlas
    lift : (n, template vertices) sparse: ``lift @ positions`` takes template vertices' values here
    vertex_of : (template vertices,) int64, the vertex here that stands for each of the template's
    """

    vertices: np.ndarray
    tracing: TracingSurface
    uv: np.ndarray
    lift: sp.csr_matrix
    vertex_of: np.ndarray


def build_flow_surface(vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray, edge_length: float) -> FlowSurface:
    """Weld, split into fans and refine a template.

    vertices (v, 3) float64 metres and faces (f, 3) int32 of the template; uv (f, 3, 2) float64 places of face corners;
    edge_length: longest edge as a share of the bounding-box diagonal. Collapsed faces are left out.
    Raises ValueError where every face is collapsed.
    """
    _, welded_faces, welded = weld(vertices, faces)
    whole = np.flatnonzero(
        (welded_faces[:, 0] != welded_faces[:, 1])
        & (welded_faces[:, 1] != welded_faces[:, 2])
        & (welded_faces[:, 2] != welded_faces[:, 0])
    )
    if len(whole) == 0:
        raise ValueError("faces: expected at least one face with three different corners")
    first = np.full(welded.max() + 1, len(vertices), np.int64)
    np.minimum.at(first, welded, np.arange(len(vertices)))
    kept = first[welded_faces[whole]]
    neighbor, entry = match_halfedges(vertices, kept)
    fans, origin = split_fans(kept, neighbor, entry)
    extent = vertices[kept.ravel()]
    diagonal = float(np.linalg.norm(extent.max(axis=0) - extent.min(axis=0)))
    finer, fine_faces, fine_uv = refine(vertices[origin], fans, uv[whole], edge_length * diagonal)
    pick = sp.csr_matrix((np.ones(len(origin)), (np.arange(len(origin)), origin)), shape=(len(origin), len(vertices)))
    lift = (finer @ pick).tocsr()
    positions = lift @ vertices
    # Everything later walks over neighbours: keep them together in memory.
    order = morton_order(positions)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    lift, positions, fine_faces, fans = lift[order], positions[order], rank[fine_faces], rank[fans]
    order = morton_order(positions[fine_faces].mean(axis=1))
    fine_faces, fine_uv = fine_faces[order], fine_uv[order]
    group = np.zeros(len(first), np.int64)
    group[welded_faces[whole].ravel()] = fans.ravel()
    vertex_of = group[welded]
    vertex_of[faces[whole].ravel()] = fans.ravel()
    return FlowSurface(positions, TracingSurface(positions, fine_faces), fine_uv, lift, vertex_of)
