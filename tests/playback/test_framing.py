import io

import numpy as np
from memory_capture import box
from PIL import Image

from unstructured_mg.playback.framing import CLOSE_METRES, Framing, encode
from unstructured_mg.playback.render import Drawable, drawable_frame

WALK = [drawable_frame(box((90, 90, 90), at=(x, 0, 0))) for x in (0.0, 0.4, 0.8)]


def test_one_camera_holds_all_and_fits_the_cell():
    framing = Framing.of(WALK)
    for largest in ((340, 190), (200, 400)):
        camera = framing.camera(largest)
        assert camera.height <= largest[0] and camera.width <= largest[1]
        assert camera.height == largest[0] or camera.width == largest[1]
        for each in WALK:
            picture = camera.project(each.vertices)
            x, y = picture[:, 0] / picture[:, 3], picture[:, 1] / picture[:, 3]
            assert 0 < x.min() and x.max() < camera.width and 0 < y.min() and y.max() < camera.height
    np.testing.assert_allclose(framing.centre, [0.4, 0.0], atol=1e-12)


def test_a_wide_motion_gets_wide_cells():
    assert Framing.of(WALK[:1]).aspect < Framing.of(WALK).aspect


def test_debris_does_not_shrink_the_figure():
    far = box((0, 0, 0), size=(0.01, 0.01, 0.01), at=(50, 50, 9))
    mesh = WALK[0]
    littered = Drawable(np.vstack([mesh.vertices, far.vertices]), np.vstack([mesh.faces, far.faces + 8]))
    clean, other = Framing.of([mesh]), Framing.of([littered])
    np.testing.assert_array_equal(clean.camera((300, 300)).position, other.camera((300, 300)).position)


def test_the_close_view_shows_the_upper_end_large():
    framing = Framing.of(WALK[:1])
    whole, close = framing.camera((300, 200)), framing.close_camera(200, 200)

    def pixels_a_metre(camera):
        ends = camera.project(np.array([[0, 0, 1.8 - CLOSE_METRES], [0, 0, 1.8]]))
        rows = ends[:, 1] / ends[:, 3]
        assert (rows > 0).all() and (rows < camera.height).all()
        return (rows[0] - rows[1]) / CLOSE_METRES

    assert pixels_a_metre(close) > 2 * pixels_a_metre(whole)


def test_encoded_pictures_are_near_what_they_show():
    image = np.full((32, 48, 3), (200, 60, 90), np.uint8)
    picture = encode(image)
    assert (picture.width, picture.height) == (48, 32)
    assert np.abs(np.asarray(Image.open(io.BytesIO(picture.data))).astype(int) - image).max() <= 3
