import numpy as np
import pytest
from memory_capture import box

from unstructured_mg.playback.camera import fit_camera
from unstructured_mg.playback.render import drawable_frame
from unstructured_mg.playback.stage import BACKDROP, Stage


@pytest.mark.parametrize("field_of_view", [0.0, 0.5])
def test_grid_lines_lie_on_multiples_of_half_a_metre_on_the_floor(field_of_view):
    corners = np.array([[x, y, 0.0] for x in (-1, 1) for y in (-1, 1)])
    camera = fit_camera(
        [corners], height=400, width=400, azimuth=-np.pi / 2, elevation=1.2, field_of_view=field_of_view
    )
    picture = Stage.of(camera, np.zeros(2)).under(drawable_frame(box((0, 0, 0), at=(9, 9, 5))))

    def brightness(points):
        projected = camera.project(np.array(points, float))
        column, row = (projected[:, :2] / projected[:, 3:]).astype(int).T
        return picture[row, column].astype(int).sum(axis=1)

    along = np.linspace(0.07, 0.43, 7)
    on_line = brightness([(0.5, y, 0) for y in along] + [(x, -0.5, 0) for x in along])
    between = brightness([(0.25, y, 0) for y in along] + [(x, -0.25, 0) for x in along])
    assert on_line.max() < between.min()


def test_the_floor_is_darkest_under_the_feet_and_the_sky_is_plain():
    low, high = (drawable_frame(box((0, 0, 0), at=(0, 0, height))) for height in (0.0, 1.0))
    camera = fit_camera([low.vertices, high.vertices], height=300, width=300, azimuth=-np.pi / 2, elevation=0.15)
    stage = Stage.of(camera, np.zeros(2))
    standing, jumping = stage.under(low), stage.under(high)
    projected = camera.project(np.array([[0.1, -0.1, 0.0]]))[0]
    column, row = (projected[:2] / projected[3]).astype(int)
    assert standing[row, column].sum() < 0.5 * sum(BACKDROP)
    assert jumping[row, column].sum() > 0.9 * sum(BACKDROP)
    assert (standing[:20] == BACKDROP).all()
    assert standing.shape == (300, 300, 3) and standing.dtype == np.uint8
