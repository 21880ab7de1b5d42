"""Blend in a latent space learnt from the frames themselves (R section 4.6)."""

import numpy as np

from unstructured_mg.synthesis.align import vertex_areas
from unstructured_mg.synthesis.blend_linear import between
from unstructured_mg.synthesis.latent.centre import centre_on
from unstructured_mg.synthesis.latent.learn import learn
from unstructured_mg.synthesis.latent.model import LatentModel
from unstructured_mg.synthesis.latent.options import LatentOptions
from unstructured_mg.synthesis.pose import pose_parts
from unstructured_mg.synthesis.posture import Posture, Template

# Two windows hold few frames: half of what a whole capture is given, in a third of the time.
OPTIONS = LatentOptions(epochs=1500, exchanges=200)


class LatentBlend:
    """Straight lines between latents, decoded: D((1-l) z_s + l z_t) + (1-l) r_s + l r_t (R section 4.6.2).

    r is what the decoder misses of each end, so that both ends are met, which R leaves out. The model is learnt from
    the template's tracked frames, which share one connectivity even where the capture does not, or given. Shapes are
    placed as in P section 6.5.
    """

    def __init__(self, template: Template, model: LatentModel | None = None):
        self._model = model or learn(template.frames, template.faces, OPTIONS)
        self._masses = vertex_areas(template.surface, template.faces)
        self._parts = np.zeros(len(template.surface), np.int32)

    def __call__(self, source: Posture, target: Posture, weight: float) -> Posture:
        ends = np.stack([centre_on(posture.surface, self._model.mean).shape for posture in (source, target)])
        latents = self._model.encode(ends)
        missed = ends - self._model.decode(latents)
        decoded = self._model.decode(between(latents[:1], latents[1:], weight))[0]
        new = decoded + between(missed[0], missed[1], weight)
        middle = between(source.surface, target.surface, weight)
        return Posture(pose_parts(new, middle, self._masses, self._parts), None)
