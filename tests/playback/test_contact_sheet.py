import io
import pickle

import numpy as np
import pytest
from memory_capture import box, memory_capture
from PIL import Image

from unstructured_mg.geometry.planar import PlanarRigid
from unstructured_mg.playback.contact_sheet import render_transition_pictures
from unstructured_mg.synthesis.transition import Transition

K = 4
SOURCE, TARGET = 8, 22
# The target stands elsewhere, turned; the alignment brings it to the source's place.
ALIGNMENT = PlanarRigid(0.7, 1.0, -2.0)


def frame_colour(index):
    return (200, 8 * index, 40)


def step_colour(step):
    return (30, 120, 128 + 25 * step)


def scene(first=0, frames=31):
    meshes = []
    for index in range(first, first + frames):
        mesh = box(frame_colour(index))
        if index > 15:
            mesh = box(frame_colour(index), at=(0, 0, 0))
            mesh.vertices[:] = ALIGNMENT.inverse().apply(mesh.vertices)
        meshes.append(mesh)
    capture = memory_capture([("take", number) for number in range(first, first + frames)], meshes)
    body = box((0, 0, 0))
    steps = range(-K + 1, K)
    transition = Transition(
        SOURCE - first,
        TARGET - first,
        K,
        np.stack([body.vertices] * len(steps)),
        body.faces,
        body.uv,
        body.face_uv,
        (),
        ".jpg",
        np.stack([np.full((8, 3), step_colour(step), np.uint8) for step in steps]),
        ALIGNMENT,
        {},
    )
    return capture, transition


def decode(picture):
    image = np.asarray(Image.open(io.BytesIO(picture.data)))
    assert image.shape == (picture.height, picture.width, 3)
    return image.astype(int)


def cell_colours(picture, count, row_share):
    image = decode(picture)
    width = picture.width // count
    row = int(row_share * picture.height)
    return [
        image[row - 3 : row + 4, i * width + width // 2 - 3 : i * width + width // 2 + 4].mean(axis=(0, 1))
        for i in range(count)
    ]


@pytest.fixture(scope="module")
def pictures():
    return render_transition_pictures(*scene())


def test_the_sheet_shows_the_right_frames_in_the_right_order(pictures):
    steps = list(range(-K + 1, K))
    assert [column.label for column in pictures.columns] == [
        "2",
        "3",
        "4",
        "−3",
        "−2",
        "−1",
        "0",
        "+1",
        "+2",
        "+3",
        "26",
        "27",
        "28",
    ]
    assert [column.kind for column in pictures.columns] == ["source"] * 3 + ["step"] * 7 + ["target"] * 3
    expected = (
        [frame_colour(i) for i in (2, 3, 4)] + [step_colour(i) for i in steps] + [frame_colour(i) for i in (26, 27, 28)]
    )
    # Every figure stands in the middle of its cell only if the alignment was applied to the target's frames.
    for share in (0.3, 0.9):
        np.testing.assert_allclose(cell_colours(pictures.sheet, 13, share), expected, atol=6)


def test_the_seams_are_marked_on_the_sheet(pictures):
    image = decode(pictures.sheet)
    width = pictures.sheet.width // 13
    for column in (3, 10):
        np.testing.assert_allclose(
            image[:, column * width - 1 : column * width + 1].mean(axis=(0, 1)), (224, 122, 31), atol=20
        )


def test_the_film_holds_every_frame(pictures):
    assert pictures.film_frames == 3 + 2 * K - 1 + 3
    assert pictures.film_steps == (3, 3 + 2 * K - 2)
    expected = [frame_colour(i) for i in (2, 3, 4)]
    expected += [step_colour(i) for i in range(-K + 1, K)] + [frame_colour(i) for i in (26, 27, 28)]
    np.testing.assert_allclose(cell_colours(pictures.film, pictures.film_frames, 0.5), expected, atol=6)


def test_the_seams_compare_the_frames_that_meet(pictures):
    meet = {"start": (frame_colour(4), step_colour(-3)), "end": (step_colour(3), frame_colour(26))}
    for seam, (first, second) in zip((pictures.start, pictures.end), meet.values(), strict=True):
        np.testing.assert_allclose(cell_colours(seam.picture, 4, 0.4)[:2], [first, second], atol=4)
        np.testing.assert_allclose(seam.change, np.abs(np.subtract(first, second)).mean(), rtol=0.03)
        # Captured neighbours differ by 8 levels of green.
        np.testing.assert_allclose(seam.own_change, 8 / 3, rtol=0.03)
    assert pictures.start.labels == ("frame 4", "step −3", "difference × 6", "capture 4 to 5")
    assert pictures.end.labels == ("step +3", "frame 26", "difference × 6", "capture 25 to 26")


def test_frames_beyond_a_gap_are_not_shown():
    capture, transition = scene(first=3, frames=25)
    pictures = render_transition_pictures(capture, transition)
    assert [column.label for column in pictures.columns if column.kind != "step"] == ["3", "4", "26", "27"]
    assert pictures.film_frames == 2 + 2 * K - 1 + 2
    assert pictures.film_steps == (2, 2 + 2 * K - 2)


def test_long_transitions_show_first_and_last_step_and_five_between():
    capture, transition = scene()
    steps = 2 * 8 - 1
    longer = Transition(
        11, 15, 8, np.repeat(transition.vertices[:1], steps, 0), transition.faces, transition.uv, transition.face_uv,
        (), ".jpg", np.repeat(transition.colors[:1], steps, 0), PlanarRigid(), {},
    )  # fmt: skip
    labels = [column.label for column in render_transition_pictures(capture, longer).columns if column.kind == "step"]
    assert labels == ["−7", "−5", "−2", "0", "+2", "+5", "+7"]


def test_the_same_bytes_again_also_after_pickling(pictures):
    capture, transition = pickle.loads(pickle.dumps(scene()))
    assert pickle.loads(pickle.dumps(render_transition_pictures(capture, transition))) == pictures
