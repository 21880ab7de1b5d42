import numpy as np
import pytest

from unstructured_mg.playback.export_options import ExportOptions
from unstructured_mg.playback.showing import shown_frames


def shown(count, fps=30.0, **options):
    return shown_frames(count, fps, ExportOptions(**options))


def test_by_default_everything_is_shown_once():
    assert shown(5) == [0, 1, 2, 3, 4]
    assert shown(5, fps=29.97) == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("fps", [7.0, 12.5, 15.0, 24.0, 25.0, 29.97, 30.0, 59.94, 60.0, 120.0])
@pytest.mark.parametrize("count", [1, 2, 30, 301])
def test_at_another_rate_the_motion_keeps_its_speed(count, fps):
    order = np.array(shown(count, fps=30.0, **{}) if fps == 30.0 else shown_frames(count, 30.0, ExportOptions(fps=fps)))
    assert order[0] == 0 and order.min() >= 0 and order.max() <= count - 1
    assert (np.diff(order) >= 0).all()
    # The frame shown is the nearest in time, and both last as long to within a frame of the slower.
    times = np.arange(len(order)) / fps
    error = np.abs(order / 30.0 - times)
    inside = times <= (count - 1) / 30.0
    assert (error[inside] <= 0.5 / 30.0 + 1e-9).all()
    assert 0 <= len(order) / fps - count / 30.0 < 1 / fps + 1e-9


def test_there_and_back_again_joins_end_and_beginning():
    assert shown(4, bounce=True) == [0, 1, 2, 3, 2, 1]
    assert shown(2, bounce=True) == [0, 1]
    assert shown(1, bounce=True) == [0]


def test_turning_points_are_held():
    assert shown(3, hold=2) == [0, 1, 2, 2, 2]
    # In a loop each end is seen 1 + hold times.
    assert shown(4, bounce=True, hold=2) == [0, 1, 2, 3, 3, 3, 2, 1, 0, 0]
