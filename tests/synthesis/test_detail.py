import numpy as np
import scipy.ndimage as nd
from textured_pairs import pattern

from unstructured_mg.synthesis.detail import EDGE, LEVEL, MOST, RADIUS, detail_energy, restore_detail


def noisy(seed, size=96):
    column, row = np.meshgrid(np.arange(size) / size, np.arange(size) / size)
    smooth = pattern(np.stack([column, row], -1), finest=6) * 0.4 + 80
    return smooth + np.random.default_rng(seed).normal(scale=10, size=(size, size, 3))


def box(values):
    return nd.uniform_filter(values, (2 * RADIUS + 1,) * 2 + (1,) * (values.ndim - 2), mode="nearest")


def differences(image, inside):
    """Differences (h, w, 2, 3) to the right and below, 0 where either texel is outside."""
    found = np.zeros((*image.shape[:2], 2, 3))
    found[:, :-1, 0] = np.diff(image, axis=1) * (inside[:, 1:] & inside[:, :-1])[:, :, None]
    found[:-1, :, 1] = np.diff(image, axis=0) * (inside[1:] & inside[:-1])[:, :, None]
    return found


def product(one, other):
    return box((one * other).sum(axis=(2, 3)))


def disc(height, width):
    y, x = np.mgrid[:height, :width]
    return (y - height / 2) ** 2 + (x - width / 3) ** 2 < (0.3 * height) ** 2


def test_energy_agrees_with_scipy():
    image = noisy(0)[:, :70]
    inside = disc(*image.shape[:2])
    steps = differences(image, inside)
    np.testing.assert_allclose(detail_energy(image, inside), product(steps, steps), rtol=1e-4, atol=1e-3)


def test_restoration_agrees_with_numpy():
    first, second = noisy(0)[:, :70], noisy(1)[:, :70]
    inside = disc(*first.shape[:2])
    image = (0.4 * first + 0.6 * second).round().clip(0, 255)
    kernel = np.array([0.25, 0.5, 0.25])
    smooth = nd.convolve1d(nd.convolve1d(image, kernel, axis=0, mode="nearest"), kernel, axis=1, mode="nearest")
    grey = (image - smooth).mean(axis=2)
    weight = np.minimum(np.abs(grey) / (np.sqrt(box(grey**2)) + 0.5), EDGE)
    detail = (image - smooth) * weight[:, :, None]
    energies = [detail_energy(end, inside) for end in (first, second)]
    own, added = differences(image, inside), differences(detail, inside)
    lacking = np.maximum(LEVEL * (0.4 * energies[0] + 0.6 * energies[1]) - product(own, own), 0)
    mixed, other = product(own, added), product(added, added)
    gain = (lacking / (mixed + np.sqrt(np.maximum(mixed**2 + other * lacking, 0)) + 1e-6)).clip(0, MOST)
    restored = image.astype(np.uint8)
    restore_detail(restored, inside, *energies, 0.6)
    expected = (image + (gain * inside)[:, :, None] * detail).clip(0, 255)
    assert np.abs(restored - expected).max() < 0.51


def test_a_blend_of_two_noises_gets_the_energy_of_one():
    first, second = noisy(0), noisy(1)
    inside = np.ones(first.shape[:2], bool)
    blend = (0.5 * (first + second)).round().clip(0, 255).astype(np.uint8)
    energies = detail_energy(first, inside), detail_energy(second, inside)
    wanted = 0.5 * (energies[0] + energies[1])
    assert detail_energy(blend, inside).mean() < 0.6 * wanted.mean()
    restore_detail(blend, inside, *energies, 0.5)
    np.testing.assert_allclose(detail_energy(blend, inside).mean(), LEVEL * wanted.mean(), rtol=0.05)


def test_a_chart_full_of_softened_grain_is_restored_beside_a_stark_border():
    """The step from a chart to what lies beside it is the same in all images, and must not hide what is lost inside."""
    first, second = noisy(0), noisy(1)
    inside = np.zeros(first.shape[:2], bool)
    inside[::12] = inside[1::12] = inside[2::12] = inside[3::12] = True
    first[~inside] = second[~inside] = 250
    blend = (0.5 * (first + second)).round().clip(0, 255).astype(np.uint8)
    energies = detail_energy(first, inside), detail_energy(second, inside)
    restore_detail(blend, inside, *energies, 0.5)
    assert detail_energy(blend, inside).mean() > 0.85 * np.mean(energies)


def test_what_is_sharp_enough_stays_to_the_bit():
    image = noisy(0).round().clip(0, 255).astype(np.uint8)
    inside = np.ones(image.shape[:2], bool)
    energy = detail_energy(image, inside)
    restored = image.copy()
    restore_detail(restored, inside, energy, energy * 0.5, 0.3)
    np.testing.assert_array_equal(restored, image)


def test_nothing_is_made_of_nothing():
    flat = np.full((40, 50, 3), 77, np.uint8)
    energy = np.full((40, 50), 300, np.float32)
    restore_detail(flat, np.ones((40, 50), bool), energy, energy, 0.5)
    assert (flat == 77).all()
