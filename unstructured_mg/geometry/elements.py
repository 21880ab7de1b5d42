"""Linear maps on triangles and tetrahedra: deformation gradients and their adjoint, and the two-sided local step."""

import numpy as np

from unstructured_mg import _native


def _checked(elements: np.ndarray, gradients: np.ndarray, vertex_count: int) -> tuple[np.ndarray, np.ndarray]:
    elements = np.ascontiguousarray(elements, dtype=np.int32)
    gradients = np.ascontiguousarray(gradients, dtype=np.float64)
    if elements.ndim != 2:
        raise ValueError(f"elements: expected shape (q, corners), got {elements.shape}")
    if gradients.shape != (*elements.shape, 3):
        raise ValueError(f"gradients: expected shape {(*elements.shape, 3)}, got {gradients.shape}")
    if elements.size and not (elements.min() >= 0 and elements.max() < vertex_count):
        raise ValueError(f"elements: expected indices in 0..{vertex_count - 1}")
    return elements, gradients


def element_deformations(vertices: np.ndarray, elements: np.ndarray, gradients: np.ndarray) -> np.ndarray:
    """F ``(q, 3, 3)``, F_e = sum_i x_i g_i^T: the linear part of the map from each rest element to ``vertices``.

    ``vertices`` (n, 3) float64; ``elements`` (q, corners) int32, triangles or tets; ``gradients`` (q, corners, 3) those
    of the corners' hat functions on the rest shape. Raises ValueError where shapes or indices do not fit.
    """
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError(f"vertices: expected shape (n, 3), got {vertices.shape}")
    elements, gradients = _checked(elements, gradients, len(vertices))
    deformations = np.empty((len(elements), 3, 3))
    _native.element_deformations(vertices, elements, gradients, elements.shape[1], deformations)
    return deformations


def element_forces(
    vertex_count: int, elements: np.ndarray, gradients: np.ndarray, sizes: np.ndarray, shapes: np.ndarray
) -> np.ndarray:
    """``(vertex_count, 3)``: for every vertex, the sum over its elements of size_e T_e g_i.

    The adjoint of ``element_deformations``: the right-hand side of min sum_e size_e |F_e - T_e|_F^2 for wanted
    ``shapes`` T (q, 3, 3), with ``sizes`` (q,) areas or volumes.
    """
    elements, gradients = _checked(elements, gradients, vertex_count)
    sizes = np.ascontiguousarray(sizes, dtype=np.float64)
    shapes = np.ascontiguousarray(shapes, dtype=np.float64)
    if sizes.shape != (len(elements),):
        raise ValueError(f"sizes: expected shape {(len(elements),)}, got {sizes.shape}")
    if shapes.shape != (len(elements), 3, 3):
        raise ValueError(f"shapes: expected shape {(len(elements), 3, 3)}, got {shapes.shape}")
    forces = np.zeros((vertex_count, 3))
    _native.element_forces(elements, gradients, sizes, shapes, elements.shape[1], forces)
    return forces


def two_sided_targets(new: np.ndarray, source: np.ndarray, target: np.ndarray, weight: float) -> np.ndarray:
    """(1-l) R_s F_s + l R_t F_t for every element, all (q, 3, 3) and relative to one rest shape.

    R_s is the rotation nearest to the map from the source's element to the new one: it minimises |R F_s - F|_F.
    """
    shapes = [np.ascontiguousarray(a, dtype=np.float64) for a in (new, source, target)]
    for name, shape in zip(("new", "source", "target"), shapes, strict=True):
        if shape.shape != (len(new), 3, 3):
            raise ValueError(f"{name}: expected shape {(len(new), 3, 3)}, got {shape.shape}")
        if not np.isfinite(shape).all():
            raise ValueError(f"{name}: expected finite entries, got NaN or infinity")
    wanted = np.empty_like(shapes[0])
    _native.two_sided_targets(*shapes, float(weight), wanted)
    return wanted
