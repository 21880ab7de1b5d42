"""The two frames of a candidate side by side, as matching saw them."""

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.playback.framing import Framing, encode
from unstructured_mg.playback.pictures import Picture
from unstructured_mg.playback.render import drawable_frame, moved

CELL = (260, 200)


def render_pair_picture(capture: Capture, candidate: Candidate) -> Picture:
    """Frame s, and frame t turned by the candidate's yaw and moved to the place of frame s: two equal cells."""
    source, target = (drawable_frame(capture.read(index)) for index in (candidate.source, candidate.target))
    turned = PlanarRigid(candidate.yaw).apply(target.vertices)
    shift = _middle(source.vertices) - _middle(turned)
    target = moved(target, PlanarRigid(candidate.yaw, float(shift[0]), float(shift[1])).apply)
    framing = Framing.of([source, target])
    return encode(np.hstack(framing.draw([source, target], framing.camera(CELL))))


def _middle(vertices: np.ndarray) -> np.ndarray:
    return (vertices.min(axis=0) + vertices.max(axis=0))[:2] / 2
