"""A captured frame as one file of the web page: its mesh and its textures together, so that they cannot part."""

import io
from typing import Any

import numpy as np
from PIL import Image

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.playback.site_codec import columns, script
from unstructured_mg.playback.site_mesh import draw_order, face_section, quantised
from unstructured_mg.playback.site_options import SiteOptions

MEDIA = "image/webp"


def frame_file(mesh: TexturedMesh, frame_id: str, name: str, options: SiteOptions) -> bytes:
    """The file ``NAME.js`` of captured frame ``frame_id``; the mesh in metres, z up."""
    pixels = [texture.pixels() for texture in mesh.textures] if len(mesh.face_uv) else []
    drawing = draw_order(mesh.faces, mesh.face_uv if pixels else mesh.face_uv[:0], mesh.face_material, len(pixels))
    positions, low, step = quantised(mesh.vertices[drawing.vertex_of], options.precision)
    images = [image_bytes(image, options) for image in pixels]
    header: dict[str, Any] = {
        "frame": frame_id,
        "corners": len(drawing.vertex_of),
        "faces": len(drawing.faces),
        "low": low.tolist(),
        "step": step,
        "steps": 1,
        "colors": 0,
        "uv": None,
        "images": [],
    }
    sections = [columns(positions), face_section(drawing)]
    if images:
        uv, header["uv"] = texture_coordinates(mesh.uv[drawing.uv_of], max(max(i.shape[:2]) for i in pixels), options)
        sections.append(columns(uv))
        header["images"] = [
            {"type": MEDIA, "bytes": len(data), "faces": faces}
            for data, faces in zip(images, drawing.faces_of_material, strict=True)
        ]
    elif mesh.colors is not None:
        header["colors"] = 1
        sections.append(columns(mesh.colors[drawing.vertex_of]))
    return script(name, header, [*sections, *images])


def texture_coordinates(uv: np.ndarray, side: int, options: SiteOptions) -> tuple[np.ndarray, dict[str, Any]]:
    """uvs (c, 2), v upwards, as uint16 steps of a quarter texel with v downwards, and what the header says of them."""
    downwards = np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1)
    steps, low, step = quantised(downwards, 0.25 / min(side, options.texture_size))
    return steps, {"low": low.tolist(), "step": step}


def image_bytes(pixels: np.ndarray, options: SiteOptions) -> bytes:
    """An image (height, width, 3) uint8 as WebP, scaled down where a side is longer than the page's images may be."""
    image = Image.fromarray(pixels)
    scale = options.texture_size / max(image.size)
    if scale < 1:
        width, height = (max(round(side * scale), 1) for side in image.size)
        image = image.resize((width, height), Image.Resampling.LANCZOS)
    out = io.BytesIO()
    image.save(out, "WEBP", quality=options.quality)
    return out.getvalue()
