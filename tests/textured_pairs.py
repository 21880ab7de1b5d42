"""Small tracked pairs with procedural textures, whose true colours are known at every surface point."""

from dataclasses import dataclass, field

import numpy as np

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.tracking.pair import TrackedPair


@dataclass(frozen=True)
class ArrayTexture:
    """Stands for capture.mesh.Texture where pixels are in memory."""

    array: np.ndarray

    def pixels(self) -> np.ndarray:
        return self.array


@dataclass(frozen=True)
class ArrayCapture:
    """Stands for Capture where frames are in memory."""

    meshes: list[TexturedMesh]
    reads: list[int] = field(default_factory=list)

    def read(self, index: int) -> TexturedMesh:
        self.reads.append(index)
        return self.meshes[index]


def grid(columns: int, rows: int, width: float = 1.0, height: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Vertices ((columns + 1) (rows + 1), 3) and faces of a rectangle in z = 0."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    i = np.arange(x.size).reshape(x.shape)
    a, b, c, d = i[:-1, :-1].ravel(), i[:-1, 1:].ravel(), i[1:, 1:].ravel(), i[1:, :-1].ravel()
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)


def tube(around: int, along: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A closed-up tube (open ends) of radius 0.15 and height 1 whose atlas has a seam: vertices, faces, uv, face_uv."""
    flat, faces = grid(around, along)
    angle = 2 * np.pi * flat[:, 0]
    vertices = np.stack([0.15 * np.cos(angle), 0.15 * np.sin(angle), flat[:, 1]], axis=1)
    column = np.arange(len(flat)) % (around + 1)
    joined = np.arange(len(flat)) - np.where(column == around, around, 0)
    used, faces_joined = np.unique(joined[faces], return_inverse=True)
    uv = 0.05 + 0.9 * flat[:, :2]
    return vertices[used], faces_joined.reshape(-1, 3).astype(np.int32), uv, faces


def pattern(place: np.ndarray, seed: int = 0, waves: int = 40, finest: float = 40.0) -> np.ndarray:
    """Smooth colours (..., 3) in 0..255 of places (..., d): a sum of plane waves with finer ones fainter."""
    generator = np.random.default_rng(seed)
    frequency = finest ** generator.uniform(0.2, 1, waves)
    direction = generator.normal(size=(waves, place.shape[-1]))
    direction *= (frequency / np.linalg.norm(direction, axis=1))[:, None]
    phase, strength = generator.uniform(0, 2 * np.pi, waves), frequency**-0.7
    tint = generator.uniform(-1, 1, (waves, 3)) + 0.7
    total = (np.sin(place @ direction.T + phase) * strength) @ tint
    return (128 + 35 * total / np.sqrt((strength**2).sum() / 2)).clip(0, 255)


def tracked_pair(vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray, face_uv: np.ndarray, **other) -> TrackedPair:
    """A pair of frames 0 .. len(vertices) - 1 with template 0; vertices (frames, n, 3)."""
    frames = len(vertices)
    values = dict(
        source=0, target=frames - 1, k=1, frames=np.arange(frames, dtype=np.int32), template=0, vertices=vertices,
        faces=faces, uv=uv, face_uv=face_uv, face_material=None, cage_vertices=np.zeros((frames, 4, 3)),
        tets=np.array([[0, 1, 2, 3]], np.int32), tet_of_vertex=np.zeros(vertices.shape[1], np.int32),
        weights=np.full((vertices.shape[1], 4), 0.25), residual=np.zeros(vertices.shape), yaw=0.0, measures={},
    )  # fmt: skip
    return TrackedPair(**{**values, **other})


def psnr(one: np.ndarray, other: np.ndarray) -> float:
    """Peak signal-to-noise ratio in dB of values in 0..255."""
    error = ((np.asarray(one, np.float64) - np.asarray(other, np.float64)) ** 2).mean()
    return float(10 * np.log10(255**2 / max(error, 1e-12)))
