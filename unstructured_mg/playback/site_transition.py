"""A transition as one file of the web page: all steps' shapes, both end textures, and the flow that warps them."""

import io
from typing import Any

import numpy as np
from PIL import Image, ImageDraw
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from unstructured_mg.errors import UserError
from unstructured_mg.playback.site_codec import columns, script
from unstructured_mg.playback.site_frame import MEDIA, image_bytes, texture_coordinates
from unstructured_mg.playback.site_mesh import Drawing, draw_order, face_section, quantised
from unstructured_mg.playback.site_options import SiteOptions
from unstructured_mg.synthesis.texture_flow import TextureFlow
from unstructured_mg.synthesis.transition import Transition

# Texels around a chart that continue its surface (synthesis fills them), less half a texel of filtering.
MARGIN = 3.5
# Largest chart map, pixels a side: what decides whether a flow stays inside a chart.
MAP_SIDE = 1024
SHORTENINGS = 8


def transition_file(transition: Transition, source_id: str, target_id: str, name: str, options: SiteOptions) -> bytes:
    """The file ``NAME.js`` of a transition, its steps in the source's captured place.

    Positions are predicted in time: the first step is written as it is, the second as its difference from the first,
    every later one as the difference of its difference, all modulo 2^16.

    Raises
    ------
    UserError
        Where the transition has textures and no flow between its ends.
    """
    textured, flow = len(transition.textures) > 0, transition.flow
    drawing = draw_order(
        transition.faces, transition.face_uv if textured else transition.face_uv[:0], None, 1 if textured else 0
    )
    positions, low, step = quantised(transition.vertices[:, drawing.vertex_of], options.precision)
    header: dict[str, Any] = {
        "transition": [source_id, target_id],
        "corners": len(drawing.vertex_of),
        "faces": len(drawing.faces),
        "low": low.tolist(),
        "step": step,
        "steps": len(positions),
        "colors": 0,
        "uv": None,
        "images": [],
    }
    sections = [columns(predicted) for predicted in _predicted(positions)]
    sections.append(face_section(drawing))
    images: list[bytes] = []
    if textured:
        if flow is None:
            raise UserError(
                f"the transition from {source_id} to {target_id} has no flow.npz: it is an earlier version's; run umg "
                "build again."
            )
        ends = [_decoded(data) for data in flow.textures]
        images = [image_bytes(pixels, options) for pixels in ends]
        uv, header["uv"] = texture_coordinates(transition.uv[drawing.uv_of], max(ends[0].shape[:2]), options)
        moves = _moves(transition, flow, drawing, ends[0].shape[:2])
        steps, moves_low, moves_step = quantised(moves, header["uv"]["step"] / 4)
        header["flow"] = {"low": moves_low.tolist(), "step": moves_step}
        sections += [columns(uv), columns(steps)]
        header["images"] = [{"type": MEDIA, "bytes": len(data), "faces": len(drawing.faces)} for data in images]
    elif transition.colors is not None:
        header["colors"] = len(positions)
        sections += [columns(colors[drawing.vertex_of]) for colors in transition.colors]
    return script(name, header, [*sections, *images])


def shortened_flow(
    uv: np.ndarray, face_uv: np.ndarray, uv_flow: np.ndarray, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """The flow where a straight move of uv stays on the surface, shorter where it would leave a chart's margin.

    A page looks up ``start(uv - l v)`` and ``end(uv + (1 - l) v)``. Beyond its chart's margin lies another part of the
    surface: there v is shortened, down to 0, where the ends only fade into each other.

    Parameters
    ----------
    uv : (q, 2), v upwards; face_uv : (m, 3); uv_flow : (q, 2)
    height, width : of the images

    Returns
    -------
    flow : (q, 2) float64
    share : (q,) float64, what is left of each, 0 to 1
    """
    pixel = np.array([width, height]) * min(1.0, MAP_SIDE / max(height, width))
    columns_, rows = (max(int(side), 1) for side in np.rint(pixel))
    chart = _charts(len(uv), face_uv)
    place = np.stack([uv[:, 0] * columns_, (1 - uv[:, 1]) * rows], axis=1)
    picture = Image.new("I", (columns_, rows), -1)
    draw = ImageDraw.Draw(picture)
    for corners, of in zip(place[face_uv].reshape(-1, 6).tolist(), chart[face_uv[:, 0]].tolist(), strict=True):
        draw.polygon(corners, fill=of, outline=of)
    owner = np.asarray(picture)
    away, nearest = distance_transform_edt(owner < 0, return_indices=True)
    owner = np.where(away <= MARGIN * columns_ / width, owner[tuple(nearest)], -1)
    move = uv_flow * [columns_, -rows]
    share = np.zeros(len(uv))
    stays = np.ones(len(uv), bool)
    for part in np.arange(1, SHORTENINGS + 1) / SHORTENINGS:
        for way in (part, -part):
            column, row = np.floor(place + way * move).astype(int).T
            inside = (column >= 0) & (column < columns_) & (row >= 0) & (row < rows)
            stays &= inside & (owner[np.clip(row, 0, rows - 1), np.clip(column, 0, columns_ - 1)] == chart)
        share[stays] = part
    # Less than a quarter of a pixel crosses nothing that one could see.
    share[np.abs(move).max(axis=1) < 0.25] = 1
    return uv_flow * share[:, None], share


def _charts(count: int, face_uv: np.ndarray) -> np.ndarray:
    """(count,) the chart of each uv: those that faces join."""
    ends = np.concatenate([face_uv[:, :2], face_uv[:, 1:]])
    joined = coo_matrix((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(count, count))
    return connected_components(joined, directed=False)[1]


def _moves(transition: Transition, flow: TextureFlow, drawing: Drawing, size: tuple[int, ...]) -> np.ndarray:
    """(c, 2) the flow at each corner, v downwards."""
    kept, _ = shortened_flow(transition.uv, transition.face_uv, flow.uv_flow.astype(np.float64), size[0], size[1])
    return kept[drawing.uv_of] * [1, -1]


def _predicted(positions: np.ndarray) -> list[np.ndarray]:
    return list(np.concatenate([positions[:1], np.diff(positions[:2], axis=0), np.diff(positions, n=2, axis=0)]))


def _decoded(data: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image.convert("RGB"))
