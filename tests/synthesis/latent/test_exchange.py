import numpy as np
from toy_pair import bend, club

from unstructured_mg.synthesis.latent.centre import centre_all
from unstructured_mg.synthesis.latent.exchange import Exchange


def edge_lengths(shape, faces):
    return np.linalg.norm(shape[..., faces, :] - shape[..., np.roll(faces, 1, axis=1), :], axis=-1)


def test_between_equal_frames_nothing_changes():
    template = club()
    shapes, _ = centre_all(np.repeat(bend(template.surface, 0.5)[None], 4, axis=0))
    made = Exchange(shapes, template.faces).draw(np.random.default_rng(0))
    np.testing.assert_allclose(made, shapes[0], atol=1e-9)


def test_turned_frames_are_exchanged_without_strain():
    """Frames that are rigid copies have nothing to exchange but the turn of the part that a part hangs on."""
    template = club()
    turned = np.stack([template.surface, template.surface[:, [1, 2, 0]], template.surface[:, [2, 0, 1]]])
    shapes = turned - turned.mean(axis=1, keepdims=True)
    made = Exchange(shapes, template.faces).draw(np.random.default_rng(3))
    rest = edge_lengths(shapes[0], template.faces)
    np.testing.assert_allclose(edge_lengths(made, template.faces), rest, rtol=1e-6)


def test_exchanged_parts_keep_their_edges_and_make_new_shapes():
    template = club()
    shapes, _ = centre_all(np.stack([bend(template.surface, angle) for angle in (-0.8, 0.2, 1.0)]))
    exchange, random = Exchange(shapes, template.faces), np.random.default_rng(1)
    rest = edge_lengths(shapes, template.faces).mean(axis=0)
    longest = np.abs(edge_lengths(shapes, template.faces) / rest - 1).max()
    for _ in range(6):
        made = exchange.draw(random)
        assert np.abs(edge_lengths(made, template.faces) / rest - 1).max() < 1.5 * longest
        assert np.abs(made - shapes).max(axis=(1, 2)).min() > 1e-4
