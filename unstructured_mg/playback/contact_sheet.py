"""Pictures of one transition: a contact sheet, both seams before and after, and a film strip that can be played."""

import io
from collections.abc import Callable, Sequence

import numpy as np
from PIL import Image

from unstructured_mg.capture.capture import Capture
from unstructured_mg.playback.camera import Camera, fit_camera
from unstructured_mg.playback.colormap import color_map
from unstructured_mg.playback.facing import facing
from unstructured_mg.playback.pictures import Column, Picture, Seam, TransitionPictures
from unstructured_mg.playback.render import Drawable, drawable_frame, drawable_step, render
from unstructured_mg.playback.stage import stage
from unstructured_mg.synthesis.transition import Transition

# Captured frames shown on each side; synthesized ones on the sheet.
CONTEXT, SHOWN_STEPS = 3, 7
# Pixels: the largest height and width of a cell, which takes the shape of what the motion fills.
SHEET_CELL, SEAM_CELL, FILM_CELL, ZOOM_HEIGHT = (340, 190), (460, 320), (320, 240), 190
# Camera: a quarter off the figure's front, a little from above.
AZIMUTH_OFFSET, ELEVATION = np.radians(-22.0), np.radians(9.0)
SEAM_COLOR = (224, 122, 31)
# A difference of 255 / DIFFERENCE_GAIN levels is shown at the heat map's end.
DIFFERENCE_GAIN = 6


def render_transition_pictures(capture: Capture, transition: Transition) -> TransitionPictures:
    """Draw a transition between the captured frames around it, everything in the source's captured place.

    The captured frames of the target are moved by the transition's alignment. One camera serves each row of pictures,
    so that what moves in them moves in the scene. Reads up to eight captured frames.
    """
    k = transition.k
    first, last = transition.source - k, transition.target + k
    before = [index for index in _same_run(capture, first) if first - CONTEXT < index <= first]
    after = [index for index in _same_run(capture, last) if last <= index < last + CONTEXT]
    captured = {index: drawable_frame(capture.read(index)) for index in {*before, first + 1}}
    placed = {
        index: _moved(drawable_frame(capture.read(index)), transition.alignment.apply) for index in {*after, last - 1}
    }
    steps = {step: drawable_step(transition, step) for step in range(-k + 1, k)}
    shown = sorted({int(step) for step in np.rint(np.linspace(-k + 1, k - 1, min(SHOWN_STEPS, 2 * k - 1)))})

    columns = tuple(
        [Column("source", capture.frame_id(index)) for index in before]
        + [Column("step", f"{step:+d}" if step else "0") for step in shown]
        + [Column("target", capture.frame_id(index)) for index in after]
    )
    row = [captured[i] for i in before] + [steps[i] for i in shown] + [placed[i] for i in after]
    film = [captured[i] for i in before] + [steps[i] for i in steps] + [placed[i] for i in after]
    azimuth = facing(captured[first].vertices, captured[first].faces) + AZIMUTH_OFFSET
    points = [drawable.vertices for drawable in film]
    centre = np.mean([(each.min(axis=0) + each.max(axis=0))[:2] / 2 for each in points], axis=0)
    aspect = _aspect(points, azimuth)

    def draw(drawables: Sequence[Drawable], camera: Camera) -> list[np.ndarray]:
        return [render(each, camera, background=stage(camera, each, centre)).image for each in drawables]

    whole = _camera(points, SHEET_CELL, aspect, azimuth)
    zoom = _zoomed(points, ZOOM_HEIGHT, whole.width, azimuth)
    marks = (len(before), len(before) + len(shown))
    sheet = np.vstack([_strip(draw(row, whole), marks), _strip(draw(row, zoom), marks)])
    seam_camera = _camera(points, SEAM_CELL, aspect, azimuth)
    return TransitionPictures(
        capture.frame_id(transition.source),
        capture.frame_id(transition.target),
        columns,
        _encode(sheet),
        _seam(
            (captured[first], f"frame {capture.frame_id(first)}"),
            (steps[-k + 1], f"step {-k + 1:+d}"),
            (captured[first], captured[first + 1]),
            f"{capture.frame_id(first)} to {capture.frame_id(first + 1)}",
            seam_camera,
            centre,
        ),
        _seam(
            (steps[k - 1], f"step {k - 1:+d}"),
            (placed[last], f"frame {capture.frame_id(last)}"),
            (placed[last - 1], placed[last]),
            f"{capture.frame_id(last - 1)} to {capture.frame_id(last)}",
            seam_camera,
            centre,
        ),
        _encode(np.hstack(draw(film, _camera(points, FILM_CELL, aspect, azimuth)))),
        len(film),
        (len(before), len(before) + 2 * k - 2),
        float(capture.fps),
    )


def _same_run(capture: Capture, index: int) -> range:
    return next(run for run in capture.runs() if index in run)


def _moved(drawable: Drawable, move: Callable[[np.ndarray], np.ndarray]) -> Drawable:
    return Drawable(
        move(drawable.vertices),
        drawable.faces,
        drawable.uv,
        drawable.face_uv,
        drawable.images,
        drawable.face_material,
        drawable.colors,
    )


def _aspect(points: Sequence[np.ndarray], azimuth: float) -> float:
    """Width over height of a cell that the whole motion fills, within reason."""
    probe = fit_camera(points, height=1000, width=1000, azimuth=azimuth, elevation=ELEVATION, margin=0.0)
    picture = np.concatenate([probe.project(each) for each in points])
    width, height = np.ptp(picture[:, 0] / picture[:, 3]), np.ptp(picture[:, 1] / picture[:, 3])
    return float(np.clip(1.1 * width / max(height, 1e-9), 0.42, 1.6))


def _camera(points: Sequence[np.ndarray], largest: tuple[int, int], aspect: float, azimuth: float) -> Camera:
    height = round(min(largest[0], largest[1] / aspect))
    return fit_camera(points, height=height, width=round(height * aspect), azimuth=azimuth, elevation=ELEVATION)


def _zoomed(points: Sequence[np.ndarray], height: int, width: int, azimuth: float) -> Camera:
    """A camera on the top 36 cm of the figures, or their top fifth: head and shoulders where they stand upright."""
    tops = []
    for each in points:
        low, high = each[:, 2].min(), each[:, 2].max()
        tops.append(each[each[:, 2] >= high - max(0.36, 0.2 * (high - low))])
    # Wide gestures may leave the picture at the sides: the head stays large.
    middle = np.mean([top.mean(axis=0) for top in tops], axis=0)
    reach = 0.6 * float(np.mean([np.ptp(top[:, 2]) for top in tops])) * max(width / height, 1.0)
    kept = [top[np.hypot(*(top[:, :2] - middle[:2]).T) <= max(reach, 1e-3)] for top in tops]
    return fit_camera(
        kept if sum(map(len, kept)) else tops, height=height, width=width, azimuth=azimuth, elevation=ELEVATION
    )


def _strip(cells: list[np.ndarray], marks: Sequence[int]) -> np.ndarray:
    """Cells side by side, with a line where capture and synthesis meet."""
    strip = np.hstack(cells)
    width = cells[0].shape[1]
    for mark in marks:
        strip[:, mark * width - 2 : mark * width + 2] = SEAM_COLOR
    return strip


def _seam(
    earlier: tuple[Drawable, str],
    later: tuple[Drawable, str],
    own: tuple[Drawable, Drawable],
    own_label: str,
    camera: Camera,
    centre: np.ndarray,
) -> Seam:
    cells = [render(each, camera, background=stage(camera, each, centre)).image for each, _ in (earlier, later)]
    across, change = _difference(earlier[0], later[0], camera)
    within, own_change = _difference(*own, camera)
    labels = (
        earlier[1],
        later[1],
        f"difference × {DIFFERENCE_GAIN}",
        f"in the capture: {own_label}, × {DIFFERENCE_GAIN}",
    )
    return Seam(_encode(np.hstack([*cells, across, within])), labels, change, own_change)


def _difference(first: Drawable, second: Drawable, camera: Camera) -> tuple[np.ndarray, float]:
    """Heat map of the difference of two renderings on the same grey, and its mean over both silhouettes."""
    one, other = (render(each, camera, background=(128, 128, 128)) for each in (first, second))
    levels = np.abs(one.image.astype(np.int64) - other.image).sum(axis=2) / 3
    covered = (one.coverage > 0) | (other.coverage > 0)
    mean = float(levels[covered].mean()) if covered.any() else 0.0
    heat = color_map(np.minimum(levels * DIFFERENCE_GAIN / 255, 1.0))
    # Where there is no figure the ground is a little lighter than "no difference", so that the outline shows.
    heat[~covered] = (46, 50, 66)
    return heat, mean


def _encode(image: np.ndarray) -> Picture:
    data = io.BytesIO()
    Image.fromarray(image).save(data, "JPEG", quality=84, optimize=True)
    return Picture(data.getvalue(), image.shape[1], image.shape[0])
