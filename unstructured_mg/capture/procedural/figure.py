"""The procedural capture: a figure whose every frame is meshed anew, with the truth known."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from unstructured_mg import _native
from unstructured_mg.capture.procedural.atlas import unwrap
from unstructured_mg.capture.procedural.body import Body, reference_body, relative_size
from unstructured_mg.capture.procedural.choreography import Action
from unstructured_mg.capture.procedural.motion import Motion, choreograph
from unstructured_mg.capture.procedural.paint import paint
from unstructured_mg.capture.procedural.remesh import opposite_half_edges, remesh
from unstructured_mg.capture.procedural.skin import pose
from unstructured_mg.geometry.closest import ClosestPoints
from unstructured_mg.geometry.laplacian import face_areas

SPREAD = 0.08  # the number of faces varies by up to this share


@dataclass(frozen=True)
class ProceduralFrame:
    """One frame as a capture would give it, and its truth.

    Attributes
    ----------
    vertices : (n, 3) float64, metres, z up, floor at 0
    faces : (m, 3) int32, closed, genus 0
    uv, face_uv : (q, 2) float64, v upwards, and (m, 3) int32
    pixels : (size, size, 3) uint8, sRGB, top row first
    chart : (m,) int32 chart of each face
    material_face : (n,) int64 face of the reference surface that each vertex lies on
    material_weights : (n, 3) float64 barycentric weights on it
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    face_uv: np.ndarray
    pixels: np.ndarray
    chart: np.ndarray
    material_face: np.ndarray
    material_weights: np.ndarray


@dataclass(frozen=True)
class ProceduralCapture:
    """A textured figure in motion at 30 frames a second; metres, z up, floor at 0.

    The reference surface has one connectivity for all frames; a frame's mesh has another connectivity and another
    atlas in every frame, and each of its vertices is a known point of the reference surface.

    Attributes
    ----------
    frames : number of frames, at least 1; a longer capture starts with the frames of a shorter one
    faces : about how many faces a frame has (500 to 20,000)
    texture_size : texels along the texture's side, at least 64
    seed : chooses timing and size of the actions, connectivity and atlases
    """

    frames: int = 300
    faces: int = 8000
    texture_size: int = 512
    seed: int = 0

    def __post_init__(self) -> None:
        for name, low, high in (("frames", 1, 10**6), ("faces", 500, 20_000), ("texture_size", 64, 8192)):
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueError(f"{name}: expected {low}..{high}, got {value}")
        if self.seed < 0:
            raise ValueError(f"seed: expected 0 or more, got {self.seed}")

    @cached_property
    def motion(self) -> Motion:
        return choreograph(self.frames, self.seed)

    @property
    def actions(self) -> tuple[Action, ...]:
        """What the figure does, stretch by stretch."""
        return self.motion.actions

    @property
    def body(self) -> Body:
        return reference_body()

    def true_surface(self, frame: int) -> tuple[np.ndarray, np.ndarray]:
        """The reference surface at ``frame``: vertices (n, 3) float64 and its faces (m, 3) int32, always the same."""
        self._check(frame)
        body = self.body
        motion = self.motion
        return pose(body.vertices, body.weights, motion.rotations[frame], motion.positions[frame]), body.faces

    def material_positions(self, face: np.ndarray, weights: np.ndarray, frame: int) -> np.ndarray:
        """Where (p, 3) the material points given by reference ``face`` (p,) and ``weights`` (p, 3) are at ``frame``."""
        vertices, faces = self.true_surface(frame)
        return np.einsum("pk,pki->pi", weights, vertices[faces[face]])

    def frame_mesh(self, frame: int) -> ProceduralFrame:
        """Mesh, unwrap and paint ``frame``; depends on nothing but the attributes and ``frame``."""
        posed, _ = self.true_surface(frame)
        body = self.body
        seeds = np.random.SeedSequence([self.seed, frame]).generate_state(3, np.uint64)
        share = 1 + SPREAD * (2 * float(seeds[2] % 10_000) / 10_000 - 1)
        surface, sizes, density = _resting()
        target = max(int(self.faces * share) // 2 * 2, 400)
        faces, face, weights = remesh(surface, body.opposite, sizes / np.sqrt(target), int(seeds[0]), target)
        resting = np.einsum("pk,pki->pi", weights, body.vertices[body.faces[face]])
        neighbours = (opposite_half_edges(faces) // 3).reshape(-1, 3)
        wanted = np.einsum("pk,pk->p", weights, density[body.faces[face]])[faces].mean(1)
        atlas = unwrap(resting, faces, neighbours, wanted, self.texture_size, int(seeds[1]))
        shade = np.einsum("pk,pk->p", weights, body.shade[body.faces[face]])
        pixels = _paint_atlas(atlas.owner, atlas.weights, faces, resting, shade)
        vertices = np.einsum("pk,pki->pi", weights, posed[body.faces[face]])
        return ProceduralFrame(vertices, faces, atlas.uv, atlas.face_uv, pixels, atlas.chart, face, weights)

    def _check(self, frame: int) -> None:
        if not 0 <= frame < self.frames:
            raise ValueError(f"frame: expected 0..{self.frames - 1}, got {frame}")


@lru_cache(maxsize=1)
def _resting() -> tuple[ClosestPoints, np.ndarray, np.ndarray]:
    """The resting body's closest-point tree, relative edge lengths and texel densities, made once a process."""
    body = reference_body()
    sizes = relative_size(body.vertices)
    # The face is what people look at: it gets twice the texels.
    density = 1 + 0.9 / (1 + np.exp(-(body.vertices[:, 2] - 1.50) / 0.012))
    # Relative lengths, scaled so that equilateral triangles of that size would cover the body with one face.
    per_face = np.sum((1 / sizes**2)[body.faces].mean(1) * face_areas(body.vertices, body.faces))
    return ClosestPoints(body.vertices, body.faces), sizes * np.sqrt(4 / np.sqrt(3) * per_face), density


def _paint_atlas(
    owner: np.ndarray, weights: np.ndarray, faces: np.ndarray, points: np.ndarray, shade: np.ndarray
) -> np.ndarray:
    size = len(owner)
    covered = np.flatnonzero(owner.ravel() >= 0)
    corners = faces[owner.ravel()[covered]]
    bary = weights.reshape(-1, 3)[covered]
    places = np.einsum("pk,pki->pi", bary, points.astype(np.float32)[corners])
    colors = np.zeros((size * size, 3), np.uint8)
    colors[covered] = paint(places, np.einsum("pk,pk->p", bary, shade.astype(np.float32)[corners]))
    # Gutters take the colour of the nearest texel of a chart, so that filtering at a seam sees no other colour.
    source = np.full(size * size, -1, np.int32)
    source[covered] = covered
    _native.spread_texels(source, size, size)
    return colors[source].reshape(size, size, 3)
