import numpy as np
import pytest
from toy_pair import bend, club

from unstructured_mg.synthesis.latent.centre import centre_all
from unstructured_mg.synthesis.latent.principal import principal_model, span_of


def bent_shapes(count=14):
    template = club()
    shapes, _ = centre_all(np.stack([bend(template.surface, angle) for angle in np.linspace(-0.5, 1.4, count)]))
    return shapes, template.faces


def test_a_span_is_orthonormal_and_holds_every_row():
    rows = np.random.default_rng(0).normal(size=(6, 40)) @ np.diag(np.linspace(1, 3, 40))
    span = span_of(rows, np.ones(6)).astype(np.float64)
    np.testing.assert_allclose(span @ span.T, np.eye(6), atol=1e-6)
    np.testing.assert_allclose(rows @ span.T @ span, rows, atol=1e-5)


def test_components_are_the_singular_vectors_and_leave_their_residual():
    shapes, faces = bent_shapes()
    model = principal_model(shapes, faces, 3)
    offsets = (shapes - shapes.mean(0)).reshape(len(shapes), -1)
    _, values, _ = np.linalg.svd(offsets, full_matrices=False)
    decoded = model.decode(model.encode(shapes))
    np.testing.assert_allclose(((decoded - shapes) ** 2).sum(), (values[3:] ** 2).sum(), rtol=1e-3)
    latents = model.encode(shapes)
    np.testing.assert_allclose(latents.T @ latents / len(shapes), np.eye(3), atol=1e-4)


def test_shapes_that_are_all_one_are_refused():
    shapes, faces = bent_shapes()
    with pytest.raises(ValueError, match="shapes: expected at least two that differ"):
        principal_model(np.repeat(shapes[:1], 5, axis=0), faces, 2)
