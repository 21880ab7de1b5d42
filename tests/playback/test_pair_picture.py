import io

import numpy as np
from memory_capture import box, memory_capture
from PIL import Image

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.playback.pair_picture import render_pair_picture


def test_the_target_stands_in_the_second_cell_as_the_source_does_in_the_first():
    yaw = 0.9
    source, target = box((200, 30, 30)), box((30, 30, 200))
    target.vertices[:] = PlanarRigid(-yaw, 3.0, 1.0).apply(target.vertices)
    picture = render_pair_picture(memory_capture([("a", 0), ("a", 1)], [source, target]), Candidate(0, 1, 0.01, yaw, 1))
    image = np.asarray(Image.open(io.BytesIO(picture.data))).astype(int)
    assert image.shape == (picture.height, picture.width, 3)
    first, second = np.split(image, 2, axis=1)
    red = (first[..., 0] > 120) & (first[..., 2] < 100)
    blue = (second[..., 2] > 120) & (second[..., 0] < 100)
    assert red.mean() > 0.2
    # The same silhouette in the same place, but for JPEG's blur of colour at its rim.
    assert (red != blue).mean() < 0.03
