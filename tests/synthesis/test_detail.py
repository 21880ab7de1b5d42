import numpy as np
import scipy.ndimage as nd
from textured_pairs import pattern

from unstructured_mg.synthesis.detail import RADIUS, detail_energy, restore_detail


def noisy(seed, size=96):
    column, row = np.meshgrid(np.arange(size) / size, np.arange(size) / size)
    smooth = pattern(np.stack([column, row], -1), finest=6) * 0.4 + 80
    return smooth + np.random.default_rng(seed).normal(scale=10, size=(size, size, 3))


def reference_energy(image):
    energy = np.zeros(image.shape[:2])
    energy[:, :-1] += (np.diff(image, axis=1) ** 2).sum(axis=2)
    energy[:-1] += (np.diff(image, axis=0) ** 2).sum(axis=2)
    return nd.uniform_filter(energy, 2 * RADIUS + 1, mode="nearest")


def test_energy_agrees_with_scipy():
    image = noisy(0)[:, :70]
    np.testing.assert_allclose(detail_energy(image), reference_energy(image), rtol=1e-4)


def test_a_blend_of_two_noises_gets_the_energy_of_one():
    first, second = noisy(0), noisy(1)
    blend = (0.5 * (first + second)).round().clip(0, 255).astype(np.uint8)
    energies = detail_energy(first), detail_energy(second)
    wanted = 0.5 * (energies[0] + energies[1])
    assert detail_energy(blend).mean() < 0.6 * wanted.mean()
    restore_detail(blend, *energies, 0.5)
    np.testing.assert_allclose(detail_energy(blend).mean(), wanted.mean(), rtol=0.05)


def test_what_is_sharp_enough_stays_to_the_bit():
    image = noisy(0).round().clip(0, 255).astype(np.uint8)
    energy = detail_energy(image)
    restored = image.copy()
    restore_detail(restored, energy, energy * 0.5, 0.3)
    np.testing.assert_array_equal(restored, image)


def test_nothing_is_made_of_nothing():
    flat = np.full((40, 50, 3), 77, np.uint8)
    energy = np.full((40, 50), 300, np.float32)
    restore_detail(flat, energy, energy, 0.5)
    assert (flat == 77).all()
