"""Opening a capture: a folder of frames to a Capture, every frame checked."""

from collections import Counter
from concurrent.futures import Executor
from functools import partial
from pathlib import Path

from unstructured_mg.capture.capture import Capture
from unstructured_mg.capture.check import CheckedFrame, check_frames
from unstructured_mg.capture.folder import list_frames
from unstructured_mg.capture.frame_file import FrameFile
from unstructured_mg.capture.frame_reader import READERS
from unstructured_mg.capture.numbering import natural_key
from unstructured_mg.capture.placement import place
from unstructured_mg.capture.progress import Progress
from unstructured_mg.capture.sidecar import check_floor, check_fps, check_unit, check_up, read_sidecar
from unstructured_mg.errors import FrameFault, UserError

DEFAULT_FPS = 30.0

# Frames a task: enough to outweigh a task's cost, few enough to share out 60 frames among many workers.
_CHUNK = 8


def open_capture(
    folder: str | Path,
    *,
    fps: float | None = None,
    unit: float | str | None = None,
    up: str | None = None,
    floor: float | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Capture:
    """Open the capture in ``folder`` and check every frame of it, in parallel where there is an ``executor``.

    What is not given is taken from the sidecar (``capture.json``), else guessed (unit, up, floor: see placement) or
    assumed (30 fps); guesses that may be wrong are in the capture's ``warnings``.

    Parameters
    ----------
    fps : frames a second
    unit : metres a capture unit, or the name of a unit (m, dm, cm, mm, inch, foot)
    up : up axis, "y", "z", "x", "-y", "-z" or "-x"
    floor : height of the floor along the up axis, in capture units
    progress : called with (frames done, all frames)

    Raises
    ------
    UserError : there is no such folder, it holds no frames or no good one, or a value given cannot be meant
    """
    folder = Path(folder).absolute()
    sidecar = read_sidecar(folder)
    given_fps = check_fps(fps) if fps is not None else sidecar.get("fps")
    given_unit = check_unit(unit) if unit is not None else sidecar.get("unit")
    given_up = check_up(up) if up is not None else sidecar.get("up")
    given_floor = check_floor(floor) if floor is not None else sidecar.get("floor")
    listing = list_frames(folder)
    files, faults, warnings = listing.frames, listing.faults, listing.warnings
    if not files and faults:
        raise UserError(f"{folder}: not one of its frames can be used: {_commonest(faults)}.")
    if not files:
        formats = " or ".join(suffix[1:].upper() for suffix in READERS)
        raise UserError(
            f"{folder}: there are no frames in it; give a folder of {formats} files with numbers in their names, or of "
            "one vologram (.vols), glTF animation, UVOL 2 or SCVV manifest."
        )
    if given_fps is None:
        given_fps = _stated_rate(listing.rates, warnings)
    checked = _check_all(files, folder, executor, progress)
    good = [frame for frame in checked if isinstance(frame, CheckedFrame)]
    faults += [frame for frame in checked if isinstance(frame, FrameFault)]
    good, untextured = _same_kind(good)
    faults += untextured
    if not good:
        raise UserError(f"{folder}: not one of its {len(files)} frames can be used: {_commonest(faults)}.")
    if not any(frame.has_texture for frame in good):
        what = "vertex colours but no texture" if all(frame.has_colors for frame in good) else "no texture"
        warnings.append(f"the frames have {what}: only geometry is matched and blended")
    if given_fps is None:
        warnings.append(f"nothing says how many frames a second there are: {DEFAULT_FPS:g} is taken (--fps gives it)")
    placement = place([frame.bounds for frame in good], given_unit, given_up, given_floor)
    clips = sorted(
        {f.clip for f in files} | {f.clip for f in faults}, key=lambda clip: (clip != ".", natural_key(clip))
    )
    return Capture(
        folder=folder,
        frames=tuple(frame.file for frame in good),
        fps=DEFAULT_FPS if given_fps is None else given_fps,
        unit=placement.unit,
        up=placement.up,
        floor=placement.floor,
        faults=tuple(sorted(faults, key=lambda fault: (clips.index(fault.clip), fault.number, fault.file))),
        warnings=(*warnings, *placement.warnings, *_strides([frame.file for frame in good])),
    )


def _stated_rate(rates: dict[str, float], warnings: list[str]) -> float | None:
    """The rate that the capture's own files state; the first clip's, with a warning, where they differ."""
    stated = list(rates.values())
    if any(abs(rate - stated[0]) > 1e-3 * stated[0] for rate in stated):
        warnings.append(f"the clips state different rates: that of the first, {stated[0]:g}, is taken (--fps gives it)")
    return stated[0] if stated else None


def _check_all(
    files: list[FrameFile], folder: Path, executor: Executor | None, progress: Progress | None
) -> list[CheckedFrame | FrameFault]:
    chunks = [files[start : start + _CHUNK] for start in range(0, len(files), _CHUNK)]
    work = partial(check_frames, folder=folder)
    checked: list[CheckedFrame | FrameFault] = []
    for results in map(work, chunks) if executor is None else executor.map(work, chunks):
        checked += results
        if progress is not None:
            progress(len(checked), len(files))
    return checked


def _same_kind(frames: list[CheckedFrame]) -> tuple[list[CheckedFrame], list[FrameFault]]:
    """Where any frame has a texture, a frame without one is a fault."""
    if not any(frame.has_texture for frame in frames):
        return frames, []
    faults = [
        FrameFault(
            frame.file.clip,
            frame.file.number,
            str(frame.file.path),
            "it has no texture, though other frames have one",
            "put its image beside it, or take the images of all frames away",
        )
        for frame in frames
        if not frame.has_texture
    ]
    return [frame for frame in frames if frame.has_texture], faults


def _commonest(faults: list[FrameFault]) -> str:
    (fault, _), *_ = Counter((fault.fault, fault.remedy) for fault in faults).most_common(1)
    first = next(item for item in faults if (item.fault, item.remedy) == fault)
    return f"of {first.file}, {first.fault}; {first.remedy}"


def _strides(files: list[FrameFile]) -> list[str]:
    """A warning for every clip in which no frame follows another, since no window fits into it."""
    numbers: dict[str, list[int]] = {}
    for file in files:
        numbers.setdefault(file.clip, []).append(file.number)
    warnings = []
    for clip, found in numbers.items():
        steps = {after - before for before, after in zip(found, found[1:], strict=False)}
        if steps and 1 not in steps:
            warnings.append(
                f"in clip {clip} the frame numbers go in steps of {min(steps)} or more: "
                "every frame stands between gaps, so number the frames 1, 2, 3 ... if none is missing"
            )
    return warnings
