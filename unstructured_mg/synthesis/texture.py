"""Textures of a transition: both end frames on the template, moved along the flow and blended (P section 6)."""

import io
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from PIL import Image as PillowImage

from unstructured_mg import _native
from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.geometry.agreeing import AgreeingPoints
from unstructured_mg.synthesis.advect import advect_images, advect_vertices
from unstructured_mg.synthesis.atlas import Atlas, build_atlas
from unstructured_mg.synthesis.detail import detail_energy, restore_detail
from unstructured_mg.synthesis.flow import Flow, FlowSolver
from unstructured_mg.synthesis.flow_surface import FlowSurface, build_flow_surface
from unstructured_mg.synthesis.frames import Frames
from unstructured_mg.synthesis.images import Image, captured_images, sample, spline_through
from unstructured_mg.synthesis.project import project_colors, smooth_normals
from unstructured_mg.synthesis.signals import fill_harmonic, vertex_signals
from unstructured_mg.synthesis.texels import Texels, at_texels, locate_texels, unbroken
from unstructured_mg.synthesis.texture_flow import TextureFlow, uv_changes
from unstructured_mg.synthesis.texture_options import TextureOptions
from unstructured_mg.tracking.pair import TrackedPair

# Surface points of a captured frame at which the seam's colour jump is measured.
SEAM_SAMPLES = 20000


@dataclass(frozen=True)
class TextureBlend:
    """The texture of a transition's interior frames, on the template's faces.

    Attributes
    ----------
    uv : (q, 2) float64 and face_uv : (m, 3) int32, the transition's own atlas; empty without images
    textures : encoded images, one a step; empty without images
    texture_suffix : ".jpg"
    colors : (steps, n, 3) uint8 where the capture has vertex colours and no images, else None
    flow : both end textures and the flow between them, for players that warp; None without any colour
    measures : numbers for the quality card, JSON-ready; colour differences are mean absolute, in sRGB grey levels
    """

    uv: np.ndarray
    face_uv: np.ndarray
    textures: tuple[bytes, ...]
    texture_suffix: str
    colors: np.ndarray | None
    flow: TextureFlow | None
    measures: dict[str, Any]


@dataclass(frozen=True)
class TextureSurface:
    """What both directions of a pair share: atlas, texels, and the surface that flow lives on.

    The surface's metric is the template frame's, so swapping both ends gives the same frames in reverse.
    ``atlas`` and ``texels`` are None where the capture has no images.
    """

    surface: FlowSurface
    atlas: Atlas | None
    texels: Texels | None

    @cached_property
    def solver(self) -> FlowSolver:
        tracing = self.surface.tracing
        return FlowSolver(self.surface.vertices, smooth_normals(self.surface.vertices, tracing.faces), tracing)


def build_texture_surface(capture: Frames, pair: TrackedPair, options: TextureOptions) -> TextureSurface:
    """Prepare the template of a pair for ``synthesize_textures``."""
    template = capture.read(int(pair.frames[pair.template]))
    vertices = pair.vertices[pair.template]
    if not template.textures:
        nowhere = np.zeros((*pair.faces.shape, 2))
        return TextureSurface(build_flow_surface(vertices, pair.faces, nowhere, options.edge_length), None, None)
    sizes = [texture.pixels().shape[:2] for texture in template.textures]
    atlas = build_atlas(
        vertices, pair.faces, pair.uv, pair.face_uv, pair.face_material, sizes, options.texture_size, options.margin
    )
    surface = build_flow_surface(vertices, pair.faces, atlas.uv[atlas.face_uv], options.edge_length)
    return TextureSurface(surface, atlas, locate_texels(surface, atlas.height, atlas.width, options.margin))


def synthesize_textures(
    capture: Frames,
    pair: TrackedPair,
    start: int,
    end: int,
    steps: int,
    options: TextureOptions,
    prepared: TextureSurface | None = None,
) -> TextureBlend:
    """Textures of ``steps`` frames between two frames of a pair, at l = i / (steps + 1), i = 1 .. steps.

    Both captured frames' colours are projected onto the template; the optical flow v between them is estimated on the
    template's surface; step l is ``(1 - l) Advect(start, l v) + l Advect(end, -(1 - l) v)``.

    Parameters
    ----------
    capture : gives the captured frames
    pair : the tracked pair
    start, end : positions in ``pair.frames`` of the frames that the transition leaves and meets
    steps : number of interior frames
    prepared : ``build_texture_surface`` of the same pair and options, where several transitions share it

    Returns
    -------
    Everything empty where a frame has neither images nor colours: the transition is geometry only.
    """
    frames = len(pair.frames)
    for name, value in (("start", start), ("end", end)):
        if not 0 <= value < frames:
            raise ValueError(f"{name}: expected a position in 0..{frames - 1}, got {value}")
    if steps < 1:
        raise ValueError(f"steps: expected at least 1, got {steps}")
    meshes = [capture.read(int(pair.frames[i])) for i in (start, end)]
    textured, colored = all(m.textures for m in meshes), all(m.colors is not None for m in meshes)
    if not textured and not colored:
        return _nothing()
    prepared = prepared or build_texture_surface(capture, pair, options)
    positions = [prepared.surface.lift @ pair.vertices[i] for i in (start, end)]
    if textured and prepared.texels is not None and prepared.atlas is not None:
        return _blend_images(pair, prepared, prepared.atlas, prepared.texels, meshes, positions, steps, options)
    if colored:
        return _blend_colors(pair, prepared, meshes, positions, steps, options)
    return _nothing()


def _nothing() -> TextureBlend:
    return TextureBlend(np.zeros((0, 2)), np.zeros((0, 3), np.int32), (), ".jpg", None, None, {})


def _blend_images(
    pair: TrackedPair,
    prepared: TextureSurface,
    atlas: Atlas,
    texels: Texels,
    meshes: list[TexturedMesh],
    positions: list[np.ndarray],
    steps: int,
    options: TextureOptions,
) -> TextureBlend:
    surface = prepared.surface
    measures: dict[str, Any] = {}
    inside = np.zeros((atlas.height, atlas.width), bool)
    inside.reshape(-1)[texels.index[texels.inside]] = True
    whole = unbroken(surface, texels)
    ends, shown, signals, energies, sharp_ends = [], [], [], [], 0.0
    for name, mesh, position in zip(("start", "end"), meshes, positions, strict=True):
        images = captured_images(mesh, options.texture_size)
        normals = smooth_normals(position, surface.tracing.faces)
        at_normals = at_texels(surface, texels, normals)
        at_normals /= np.maximum(np.linalg.norm(at_normals, axis=1, keepdims=True), 1e-300)
        colors, seen = project_colors(
            mesh, images, at_texels(surface, texels, position), at_normals, options.projection_reach,
            options.normal_agreement,
        )  # fmt: skip
        signal, known = vertex_signals(surface, texels, colors, seen)
        signal = fill_harmonic(prepared.solver.stiffness, prepared.solver.masses, signal, known)
        if not seen.all():
            unseen = np.flatnonzero(~seen)
            colors[unseen] = at_texels(surface, texels, signal)[unseen]
        image = np.zeros((atlas.height, atlas.width, 4), np.float32)
        flat = image.reshape(-1, 4)
        flat[texels.index, :3], flat[texels.index, 3] = colors.clip(0, 255), 1
        _native.fill_unknown(image, atlas.height, atlas.width)
        shown.append(encode_jpeg((image[:, :, :3] + 0.5).astype(np.uint8), options.quality))
        energies.append(detail_energy(image[:, :, :3], whole))
        sharp_ends += gradient_energy(image[:, :, :3], inside) / 2
        end = spline_through(image)
        ends.append(end)
        signals.append(signal)
        measures[f"holes_{name}"] = float(1 - seen[texels.inside].mean()) if texels.inside.any() else 0.0
        measures[f"seam_color_{name}"] = _seam_color(mesh, images, position, normals, surface, end, options)
    flow = _flow(prepared, signals, options, measures)
    blended = advect_images(surface, texels, flow.corners, ends[0], ends[1], steps)
    if options.method == "flow":
        for i, image in enumerate(blended, start=1):
            restore_detail(image, whole, energies[0], energies[1], i / (steps + 1))
    middle = blended[steps // 2] if steps % 2 else blended[steps // 2 - 1 : steps // 2 + 1].mean(axis=0)
    measures["sharpness"] = gradient_energy(middle, inside) / sharp_ends if sharp_ends > 0 else 1.0
    textures = tuple(encode_jpeg(image, options.quality) for image in blended)
    ends_and_flow = _texture_flow(pair, prepared, flow, atlas, tuple(shown), None)
    return TextureBlend(atlas.uv, atlas.face_uv, textures, ".jpg", None, ends_and_flow, measures)


def _blend_colors(
    pair: TrackedPair,
    prepared: TextureSurface,
    meshes: list[TexturedMesh],
    positions: list[np.ndarray],
    steps: int,
    options: TextureOptions,
) -> TextureBlend:
    surface = prepared.surface
    measures: dict[str, Any] = {}
    signals = []
    for name, mesh, position in zip(("start", "end"), meshes, positions, strict=True):
        normals = smooth_normals(position, surface.tracing.faces)
        colors, seen = project_colors(mesh, [], position, normals, options.projection_reach, options.normal_agreement)
        signals.append(
            fill_harmonic(prepared.solver.stiffness, prepared.solver.masses, colors.astype(np.float64), seen)
        )
        measures[f"holes_{name}"] = float(1 - seen.mean())
    flow = _flow(prepared, signals, options, measures)
    colors = advect_vertices(prepared.solver, flow.corners, signals[0], signals[1], steps)
    shown = (np.stack(signals)[:, surface.vertex_of] + 0.5).clip(0, 255).astype(np.uint8)
    ends_and_flow = _texture_flow(pair, prepared, flow, None, (), shown)
    nothing = _nothing()
    moved = colors[:, surface.vertex_of]
    return TextureBlend(nothing.uv, nothing.face_uv, (), ".jpg", moved, ends_and_flow, measures)


def _texture_flow(
    pair: TrackedPair,
    prepared: TextureSurface,
    flow: Flow,
    atlas: Atlas | None,
    images: tuple[bytes, ...],
    colors: np.ndarray | None,
) -> TextureFlow:
    """The flow on the template's vertices, with the end textures that it joins."""
    reference = pair.vertices[pair.template]
    field = np.einsum("na,nac->nc", flow.field, prepared.solver.fields.axes)
    displacement = field[prepared.surface.vertex_of]
    uv_flow = np.zeros((0, 2))
    if atlas is not None:
        uv_flow = uv_changes(reference, pair.faces, atlas.uv, atlas.face_uv, displacement)
    return TextureFlow(
        reference.astype(np.float32), displacement.astype(np.float32), uv_flow.astype(np.float32), images,
        ".jpg" if images else "", colors,
    )  # fmt: skip


def _flow(
    prepared: TextureSurface, signals: list[np.ndarray], options: TextureOptions, measures: dict[str, Any]
) -> Flow:
    if options.method == "crossfade":
        flow = prepared.solver.standing(signals[0], signals[1])
    else:
        flow = prepared.solver.estimate(signals[0], signals[1], options)
    measures["flow_residual_before"] = flow.residual_before
    measures["flow_residual_after"] = flow.residual_after
    measures["flow_unexplained"] = flow.unexplained
    return flow


def _seam_color(
    mesh: TexturedMesh,
    images: list[Image],
    position: np.ndarray,
    normals: np.ndarray,
    surface: FlowSurface,
    image: Image,
    options: TextureOptions,
) -> float:
    """Mean absolute colour difference between a captured frame and its projection, seen from the captured surface."""
    stride = -(-len(mesh.faces) // SEAM_SAMPLES)
    chosen = np.arange(0, len(mesh.faces), stride)
    corners = mesh.vertices[mesh.faces[chosen]]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(across, axis=1)
    chosen, corners, across, areas = (x[areas > 0] for x in (chosen, corners, across, areas))
    face, weights, _ = AgreeingPoints(position, surface.tracing.faces).query(
        corners.mean(axis=1), across / areas[:, None], options.projection_reach, options.normal_agreement
    )
    met = face >= 0
    if not met.any():
        return 0.0
    ours = sample(image, np.einsum("pi,pic->pc", weights[met], surface.uv[face[met]]))
    theirs = np.zeros_like(ours)
    material = np.zeros(len(mesh.faces), np.int64) if mesh.face_material is None else mesh.face_material
    places = mesh.uv[mesh.face_uv[chosen[met]]].mean(axis=1)
    for i, captured in enumerate(images):
        mine = material[chosen[met]] == i
        theirs[mine] = sample(captured, places[mine])
    difference = np.abs(ours - theirs).mean(axis=1)
    return float(difference @ areas[met] / areas[met].sum())


def gradient_energy(image: np.ndarray, inside: np.ndarray) -> float:
    """Mean squared difference of neighbouring texels inside charts: image (h, w, 3), inside (h, w) bool."""
    image = np.asarray(image, np.float32)
    total, count = 0.0, 0
    for axis in (0, 1):
        both = inside[1:] & inside[:-1] if axis == 0 else inside[:, 1:] & inside[:, :-1]
        step = np.diff(image, axis=axis)[both]
        total += float((step.astype(np.float64) ** 2).sum())
        count += step.size
    return total / max(count, 1)


def encode_jpeg(image: np.ndarray, quality: int) -> bytes:
    """JPEG bytes of (h, w, 3) uint8 without chroma subsampling; equal images give equal bytes."""
    buffer = io.BytesIO()
    PillowImage.fromarray(image).save(buffer, "JPEG", quality=quality, subsampling=0)
    return buffer.getvalue()
