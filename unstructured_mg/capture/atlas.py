"""What part of its texture a mesh uses."""

import numpy as np

#: Samples along each side of a texture.
SAMPLES = 256
# Samples tried at most, so that hostile uvs (all triangles as large as the texture) cost bounded time.
_MOST_TRIED = 1 << 22


def coverage(uv: np.ndarray, face_uv: np.ndarray, face_material: np.ndarray | None = None) -> np.ndarray:
    """How many triangles cover each of ``SAMPLES x SAMPLES`` points of every texture.

    Returns ``(materials, SAMPLES, SAMPLES) int32``, rows with v upwards. Only [0, 1] is sampled: repeats of the texture
    are not followed. Samples lie off the texels' centres, where uvs with few decimals like to have their edges.
    """
    materials = 1 if face_material is None else int(face_material.max(initial=0)) + 1
    counts = np.zeros(materials * SAMPLES * SAMPLES, np.int32)
    offset = 0.5 - 1 / np.pi**4  # no uv written in decimals puts a triangle's edge exactly on a sample
    corners = uv[face_uv] * SAMPLES - offset
    low = np.clip(np.ceil(corners.min(axis=1)), 0, SAMPLES).astype(np.int64)
    high = np.clip(np.floor(corners.max(axis=1)) + 1, 0, SAMPLES).astype(np.int64)
    size = np.maximum(high - low, 0)
    tried = size[:, 0] * size[:, 1]
    triangles = np.flatnonzero((tried > 0) & (np.cumsum(tried) <= _MOST_TRIED))
    triangle = np.repeat(triangles, tried[triangles])
    step = np.arange(len(triangle)) - np.repeat(np.cumsum(tried[triangles]) - tried[triangles], tried[triangles])
    x = low[triangle, 0] + step % size[triangle, 0]
    y = low[triangle, 1] + step // size[triangle, 0]
    a, b, c = (corners[triangle, i] for i in range(3))
    sides = np.stack(
        [(q[:, 0] - p[:, 0]) * (y - p[:, 1]) - (q[:, 1] - p[:, 1]) * (x - p[:, 0]) for p, q in ((a, b), (b, c), (c, a))]
    )
    inside = (sides > 0).all(axis=0) | (sides < 0).all(axis=0)
    texture = 0 if face_material is None else face_material[triangle[inside]].astype(np.int64)
    np.add.at(counts, (texture * SAMPLES + y[inside]) * SAMPLES + x[inside], 1)
    return counts.reshape(materials, SAMPLES, SAMPLES)
