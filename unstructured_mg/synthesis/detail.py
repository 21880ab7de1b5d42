"""Fine detail that averaging two images loses, given back: no frame of a transition is blurrier than its ends.

Blending ``(1 - l) a + l b`` keeps what a and b have in common and loses up to half the energy of what they have not:
noise, compression, detail that no flow brings together. Seen in motion, texture would soften and sharpen again.
"""

import numpy as np

from unstructured_mg import _native

# Texels around each over which energies are compared; and the factor above which it would be invention.
RADIUS = 8
MOST = 2.0


def detail_energy(image: np.ndarray) -> np.ndarray:
    """Local gradient energy ``(h, w) float32`` of an image (h, w, 3): squared differences of neighbours, averaged."""
    image = np.ascontiguousarray(image, np.float32)
    energy = np.empty(image.shape[:2], np.float32)
    _native.detail_energy(image, *energy.shape, RADIUS, energy)
    return energy


def restore_detail(image: np.ndarray, first: np.ndarray, second: np.ndarray, share: float) -> None:
    """Raise fine detail, in place, to the local energy ``(1 - share) first + share second``; never lower it.

    image (h, w, 3) uint8, contiguous; first, second (h, w) float32, from ``detail_energy`` of both ends.
    """
    _native.restore_detail(image, *image.shape[:2], RADIUS, first, second, share, MOST)
