from dataclasses import replace

import numpy as np
import pytest
from signal_toy import STEP_WIDTH, WIDTHS, color, signal_capture, signal_transition
from viewer_toy import on_disk

from unstructured_mg.capture.mesh import TexturedMesh
from unstructured_mg.errors import UserError
from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.playback.frame_ring import KEPT, FrameRing, key_of
from unstructured_mg.playback.walk import WalkFrame


def captured(index):
    return WalkFrame("capture", index, None, None, PlanarRigid())


def step(source, target, number):
    return WalkFrame("transition", None, (source, target), number, PlanarRigid())


@pytest.fixture
def ring(tmp_path):
    loads = []

    def load(source, target):
        loads.append((source, target))
        return signal_transition(source, target)

    ring = FrameRing(on_disk(signal_capture(60), tmp_path), load)
    ring.loads = loads
    yield ring
    ring.close()


def test_mesh_and_texture_of_a_frame_come_together(ring):
    for index in (0, 7, 30):
        frame = ring.get(captured(index), wait=True)
        assert frame.key == (index,) == key_of(captured(index))
        assert np.ptp(frame.vertices[:, 0]) == pytest.approx(WIDTHS[index % 4])
        assert frame.images[0].reshape(-1, 3).tolist()[0] == list(color(index))
        assert frame.faces_of_material == (2,) and len(frame.uv) == len(frame.vertices)
    frame = ring.get(step(10, 40, -1), wait=True)
    assert frame.key == (10, 40, -1) and np.ptp(frame.vertices[:, 0]) == pytest.approx(STEP_WIDTH)


def test_transitions_are_read_once_for_all_their_steps(ring):
    for number in range(-2, 3):
        assert ring.get(step(10, 40, number), wait=True) is not None
    assert ring.loads == [(10, 40)]


def test_what_comes_is_read_ahead_and_no_more_is_kept_than_the_ring_holds(ring):
    ring.want([captured(index) for index in range(5)])
    for index in range(5):
        assert ring.get(captured(index), wait=True).key == (index,)
    for index in range(5, 60):
        ring.want([captured(index)])
        assert len(ring._frames) <= KEPT
    assert ring.get(captured(59), wait=True).key == (59,)


def test_a_frame_that_went_bad_has_a_fault_and_nothing_is_shown(tmp_path):
    capture = on_disk(signal_capture(10), tmp_path)
    broken = replace(capture, mesh_of=lambda index: fails(index) if index == 3 else capture.mesh_of(index))
    ring = FrameRing(broken, signal_transition)
    assert ring.get(captured(3), wait=True) is None and "frame 3 is gone" in ring.faults[(3,)]
    assert ring.get(captured(4), wait=True) is not None and list(ring.faults) == [(3,)]
    ring.close()


def fails(index) -> TexturedMesh:
    raise UserError(f"frame {index} is gone")
