"""Which of a walk's frames an export shows, and in which order."""

from unstructured_mg.playback.export_options import ExportOptions


def shown_frames(count: int, fps: float, options: ExportOptions) -> list[int]:
    """Positions in a walk of ``count`` frames at ``fps``, in the order in which the export shows them.

    At another frame rate, frame m of the export is the walk's frame nearest to the same time, the later of two as near;
    it has as many frames as begin before the walk's last one ends. ``bounce`` then goes back through the frames between
    the first and the last, and ``hold`` repeats the turning points.
    """
    ratio = fps / (options.fps or fps)
    resampled = max(1, _ceiling(count / ratio))
    forth = [min(int(m * ratio + 0.5 + 1e-9), count - 1) for m in range(resampled)]
    end = [forth[-1]] * options.hold
    if not options.bounce:
        return forth + end
    return forth + end + forth[-2:0:-1] + [forth[0]] * options.hold


def _ceiling(value: float) -> int:
    """The least integer that is not below ``value`` but for rounding."""
    return -int(-(value - 1e-9) // 1)
