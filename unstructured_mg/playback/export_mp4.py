"""A video: every frame drawn without a graphics card, and encoded by ffmpeg as H.264."""

import io
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import chain

import numpy as np
from PIL import Image

from unstructured_mg.capture.ffmpeg import find_ffmpeg
from unstructured_mg.errors import UserError
from unstructured_mg.playback.camera import Camera
from unstructured_mg.playback.camera_course import Figure, View, fixed_course, measure_figure, orbit_course
from unstructured_mg.playback.export_format import ExportFrame, Format, Target
from unstructured_mg.playback.render import Drawable, render
from unstructured_mg.playback.stage import Stage

FILE = "walk.mp4"
QUALITY = 18  # of x264: what is lost is hard to see


def require_ffmpeg() -> None:
    """UserError where there is no ffmpeg."""
    if find_ffmpeg() is None:
        raise UserError("--format mp4 needs ffmpeg: install it, or pip install 'unstructured_mg[video]'.")


def measure(frame: ExportFrame) -> Figure:
    return measure_figure(frame.own_vertices, frame.faces)


def plan(figures: Sequence[Figure], worlds: Sequence[np.ndarray], target: Target) -> list[View]:
    height = target.options.picture_height
    if target.options.camera == "orbit":
        return orbit_course(figures, worlds, height, target.fps)
    return fixed_course(figures, worlds, height)


def prepare(frame: ExportFrame, target: Target) -> np.ndarray:
    """The frame's picture, (height, width, 3) uint8."""
    view: View = frame.view
    images = tuple(_decoded(texture.data) for texture in frame.textures) if len(frame.face_uv) else ()
    drawable = Drawable(
        frame.vertices(), frame.faces, frame.uv, frame.face_uv, images, frame.face_material, frame.colors
    )
    return render(drawable, view.camera, background=_stage(view).under(drawable)).image


def collect(pictures: Iterator[np.ndarray], target: Target) -> list[str]:
    """Write ``walk.mp4``: H.264, 4:2:0, BT.709, ready to be streamed."""
    program = find_ffmpeg()
    assert program is not None
    first = next(pictures)
    height, width = first.shape[:2]
    command = [
        program, "-v", "error", "-y",
        "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}",
        "-r", str(Fraction(target.fps).limit_denominator(1001)), "-i", "-",
        "-vf", "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p",
        "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv",
        # Two threads wherever it runs, and no version or date in the file: the same frames give the same bytes.
        "-c:v", "libx264", "-preset", "medium", "-crf", str(QUALITY), "-threads", "2",
        "-fflags", "+bitexact", "-flags:v", "+bitexact", "-map_metadata", "-1", "-movflags", "+faststart",
        str(target.folder / FILE),
    ]  # fmt: skip
    with tempfile.TemporaryFile() as said:
        encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=said)
        assert encoder.stdin is not None
        try:
            for picture in chain([first], pictures):
                encoder.stdin.write(picture.tobytes())
            encoder.stdin.close()
        except BrokenPipeError:
            pass  # it ended before its time: what it said tells why
        except BaseException:
            encoder.kill()
            raise
        finally:
            code = encoder.wait()
        if code != 0:
            said.seek(0)
            reason = " ".join(said.read().decode(errors="replace").split())[-300:] or f"exit code {code}"
            raise UserError(f"{FILE}: ffmpeg could not encode it ({reason}); install one with libx264.")
    return [FILE] * target.count


def _stage(view: View) -> Stage:
    """The ground; while a camera does not move it is worked out once a worker."""
    camera = view.camera
    numbers = np.concatenate([camera.position, camera.rotation.ravel(), view.centre])
    return _stage_of(numbers.tobytes(), camera.scale, camera.height, camera.width)


@lru_cache(maxsize=1)
def _stage_of(numbers: bytes, scale: float, height: int, width: int) -> Stage:
    position, rotation, centre = np.split(np.frombuffer(numbers), [3, 12])
    return Stage.of(Camera(position, rotation.reshape(3, 3), scale, height, width), centre)


def _decoded(data: bytes) -> np.ndarray:
    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image.convert("RGB"))


MP4 = Format(
    "mp4",
    r"walk\.mp4",
    prepare,
    collect,
    unused=dict.fromkeys(("up", "unit"), "a picture has none") | {"first_number": "its frames have no numbers"},
    pictures=True,
    space=("z", 1.0),
    require=require_ffmpeg,
    measure=measure,
    plan=plan,
)
