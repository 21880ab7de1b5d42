"""Pictures of one transition: a contact sheet, both seams before and after, and a film strip that can be played."""

from collections.abc import Sequence

import numpy as np

from unstructured_mg.capture.capture import Capture
from unstructured_mg.playback.camera import Camera
from unstructured_mg.playback.colormap import color_map
from unstructured_mg.playback.framing import Framing, encode
from unstructured_mg.playback.pictures import Column, Seam, TransitionPictures
from unstructured_mg.playback.render import Drawable, drawable_frame, drawable_step, moved, render
from unstructured_mg.synthesis.transition import Transition

# Captured frames shown on each side; synthesized ones on the sheet.
CONTEXT, SHOWN_STEPS = 3, 7
# Pixels: the largest height and width of a cell; the close view's height.
SHEET_CELL, SEAM_CELL, FILM_CELL, CLOSE_HEIGHT = (340, 190), (460, 320), (320, 240), 190
SEAM_COLOR = (224, 122, 31)
# A difference of 255 / DIFFERENCE_GAIN levels reaches the heat map's end.
DIFFERENCE_GAIN = 6
# The heat map's ground is a little lighter than "no difference", so that the figure's outline shows.
HEAT_GROUND = (46, 50, 66)


def render_transition_pictures(capture: Capture, transition: Transition) -> TransitionPictures:
    """Draw a transition between the captured frames around it, everything in the source's captured place.

    The captured frames of the target are moved by the transition's alignment. One camera serves each row of pictures,
    so that what moves in them moves in the scene. Reads up to eight captured frames.
    """
    k, name = transition.k, capture.frame_id
    first, last = transition.leaves, transition.arrives
    before = [index for index in _same_run(capture, first) if first - CONTEXT < index <= first]
    after = [index for index in _same_run(capture, last) if last <= index < last + CONTEXT]
    # Beside those that are shown: the captured neighbours that the synthesized frames stand in for.
    captured = {index: drawable_frame(capture.read(index)) for index in (*before, first + 1)}
    placed = {
        index: moved(drawable_frame(capture.read(index)), transition.alignment.apply) for index in (last - 1, *after)
    }
    steps = {step: drawable_step(transition, step) for step in range(-k + 1, k)}
    shown = [round(step) for step in np.linspace(-k + 1, k - 1, min(SHOWN_STEPS, 2 * k - 1)).tolist()]

    columns = (
        [Column("source", name(index)) for index in before]
        + [Column("step", _step_label(step)) for step in shown]
        + [Column("target", name(index)) for index in after]
    )
    row = [captured[i] for i in before] + [steps[i] for i in shown] + [placed[i] for i in after]
    film = [captured[i] for i in before] + [steps[i] for i in steps] + [placed[i] for i in after]
    framing = Framing.of([captured[first], *film])
    whole = framing.camera(SHEET_CELL)
    close = framing.close_camera(CLOSE_HEIGHT, whole.width)
    marks = (len(before), len(before) + len(shown))
    sheet = np.vstack([_strip(framing.draw(row, camera), marks) for camera in (whole, close)])
    return TransitionPictures(
        source=name(transition.source),
        target=name(transition.target),
        columns=tuple(columns),
        sheet=encode(sheet),
        start=_seam(
            framing,
            (captured[first], f"frame {name(first)}"),
            (steps[-k + 1], f"step {_step_label(-k + 1)}"),
            (captured[first], captured[first + 1], f"{name(first)} to {name(first + 1)}"),
        ),
        end=_seam(
            framing,
            (steps[k - 1], f"step {_step_label(k - 1)}"),
            (placed[last], f"frame {name(last)}"),
            (placed[last - 1], placed[last], f"{name(last - 1)} to {name(last)}"),
        ),
        film=encode(np.hstack(framing.draw(film, framing.camera(FILM_CELL)))),
        film_frames=len(film),
        film_steps=(len(before), len(before) + 2 * k - 2),
        fps=float(capture.fps),
    )


def _same_run(capture: Capture, index: int) -> range:
    return next(run for run in capture.runs() if index in run)


def _step_label(step: int) -> str:
    return f"{step:+d}".replace("-", "−") if step else "0"


def _strip(cells: list[np.ndarray], marks: Sequence[int]) -> np.ndarray:
    """Cells side by side, with a line where capture and synthesis meet."""
    strip = np.hstack(cells)
    width = cells[0].shape[1]
    for mark in marks:
        strip[:, mark * width - 2 : mark * width + 2] = SEAM_COLOR
    return strip


def _seam(
    framing: Framing, earlier: tuple[Drawable, str], later: tuple[Drawable, str], own: tuple[Drawable, Drawable, str]
) -> Seam:
    camera = framing.camera(SEAM_CELL)
    across, change = _difference(earlier[0], later[0], camera)
    within, own_change = _difference(own[0], own[1], camera)
    labels = (earlier[1], later[1], f"difference × {DIFFERENCE_GAIN}", f"capture {own[2]}")
    cells = framing.draw([earlier[0], later[0]], camera)
    return Seam(encode(np.hstack([*cells, across, within])), labels, change, own_change)


def _difference(first: Drawable, second: Drawable, camera: Camera) -> tuple[np.ndarray, float]:
    """Heat map of the difference of two renderings on the same grey, and its mean over both silhouettes."""
    one, other = (render(each, camera, background=(128, 128, 128)) for each in (first, second))
    levels = np.abs(one.image.astype(np.int64) - other.image).sum(axis=2) / 3
    covered = (one.coverage > 0) | (other.coverage > 0)
    mean = float(levels[covered].mean()) if covered.any() else 0.0
    heat = color_map(np.minimum(levels * DIFFERENCE_GAIN / 255, 1.0))
    heat[~covered] = HEAT_GROUND
    return heat, mean
