"""Fine detail that averaging two images loses, given back: no frame of a transition is blurrier than its ends.

Blending ``(1 - l) a + l b`` keeps what a and b have in common and loses up to half the energy of what they have not:
noise, compression, detail that no flow brings together. Seen in motion, texture would soften and sharpen again.
"""

import numpy as np

from unstructured_mg import _native

# Texels around each over which energies are compared.
RADIUS = 8
# Share of the ends' energy that is given back. Texels at the rims of charts get nothing: with all of it the middle of
# captured windows, rims included, has 0.90 (an atlas of many small charts) to 0.97 of its ends' gradient energy.
LEVEL = 1.0
# Detail is amplified in proportion to its own strength, up to this many times the local one: edges that averaging has
# softened regain most, grain least.
EDGE = 2.0
# Factor of amplification above which it would be invention.
MOST = 4.0


def detail_energy(image: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Local gradient energy ``(h, w) float32`` of an image (h, w, 3): squared differences of neighbours, averaged.

    Only neighbours that are both ``inside`` (h, w) bool count: the step from chart to chart is no detail (see
    ``texels.unbroken``).
    """
    image = np.ascontiguousarray(image, np.float32)
    energy = np.empty(image.shape[:2], np.float32)
    _native.detail_energy(image, _bytes(inside), *energy.shape, RADIUS, energy)
    return energy


def restore_detail(image: np.ndarray, inside: np.ndarray, first: np.ndarray, second: np.ndarray, share: float) -> None:
    """Raise fine detail, in place, to LEVEL of the local energy ``(1 - share) first + share second``; never lower it.

    Around each texel g e is added to the image, e the detail (what a binomial filter of three texels takes away) times
    min(|e| / local rms, EDGE), g >= 0 such that the energy of the sum is the wanted one, MOST at most.

    Texels that are not ``inside`` stay.

    image (h, w, 3) uint8, contiguous; inside (h, w) bool; first, second (h, w) float32, from ``detail_energy`` of both
    ends.
    """
    height, width = image.shape[:2]
    _native.restore_detail(image, _bytes(inside), height, width, RADIUS, first, second, share, LEVEL, EDGE, MOST)


def _bytes(mask: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(mask, np.uint8)
