"""An inspection as plain text for a terminal or a file."""

import io
from collections import Counter

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from unstructured_mg.capture.inspect import FrameMeasures, Inspection
from unstructured_mg.capture.placement import UNITS

# Rows of the table: what is read off a frame, its heading, and whether anything but 0 deserves a look.
_ROWS = (
    ("vertices", "vertices", False),
    ("faces", "faces", False),
    ("height", "height, m", False),
    ("width", "width (x), m", False),
    ("depth", "depth (y), m", False),
    ("lowest", "lowest point above the floor, m", False),
    ("components", "components", False),
    ("significant_components", "components of 1 % of the area or more", False),
    ("boundary_edges", "boundary edges", True),
    ("nonmanifold_edges", "non-manifold edges", True),
    ("flat_faces", "faces without area", True),
    ("uvs", "texture coordinates", False),
    ("flat_uv_faces", "faces without area in the texture", True),
    ("uv_outside", "faces outside the texture", True),
    ("texture_used", "share of the texture in use", False),
    ("texture_overlap", "share of that in use more than once", True),
    ("untextured_faces", "faces without texture", True),
    ("welded_vertices", "vertices joined at seams", False),
    ("unused_vertices", "vertices without a face, left out", True),
    ("collapsed_faces", "faces with a repeated corner, left out", True),
    ("repeated_faces", "faces there twice, left out", True),
    ("facing_away_faces", "faces with a twin facing the other way", True),
)


def inspection_text(inspection: Inspection, width: int = 110) -> str:
    """The whole inspection as text, every fault with its remedy included."""
    console = Console(file=io.StringIO(), width=width, no_color=True, legacy_windows=False, highlight=False)
    with console.capture() as captured:
        console.print(inspection_renderable(inspection))
    return "\n".join(line.rstrip() for line in captured.get().splitlines()) + "\n"


def inspection_renderable(inspection: Inspection) -> RenderableType:
    """The whole inspection for a rich console, every fault with its remedy included."""
    parts: list[RenderableType] = [_summary(inspection), _measures(inspection.frames)]
    parts += [Text(f"Note: {warning}.") for warning in inspection.warnings]
    if inspection.faults:
        parts += [Text(f"\n{len(inspection.faults)} frames cannot be used:"), _faults(inspection)]
    else:
        parts.append(Text("Every frame can be used."))
    return Group(*parts)


def _summary(inspection: Inspection) -> Table:
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    count = len(inspection.frames)
    table.add_row("capture", inspection.folder)
    seconds = count / inspection.fps
    table.add_row("frames", f"{count} good, {len(inspection.faults)} bad; {inspection.fps:g} a second, {seconds:.1f} s")
    for clip in inspection.clips:
        gaps = ", ".join(str(first) if first == last else f"{first}-{last}" for first, last in clip.gaps)
        table.add_row(
            "clip" if clip.name == "." else f"clip {clip.name}",
            f"{clip.first} to {clip.last}, {clip.frames} frames, " + (f"missing {gaps}" if gaps else "no gaps"),
        )
    names = {metres: name for name, metres in UNITS.items()}
    unit = names.get(inspection.unit, f"{inspection.unit:g} m")
    table.add_row("placement", f"unit {unit}, {inspection.up} up, floor at {inspection.floor:.4g} of that unit")
    table.add_row("connectivity", _changes(inspection.new_connectivity, count))
    sizes = Counter(frame.texture_sizes for frame in inspection.frames)
    if any(sizes):
        table.add_row("atlas", _changes(inspection.new_atlas, count))
    for size, frames in sizes.items():
        what = ", ".join(f"{width} x {height}" for width, height in size) or "none"
        table.add_row("texture", what if len(sizes) == 1 else f"{what} in {frames} frames")
    colored = sum(frame.has_colors for frame in inspection.frames)
    if colored:
        table.add_row("vertex colours", "in every frame" if colored == count else f"in {colored} frames")
    return table


def _changes(ids: tuple[str, ...], count: int) -> str:
    if not ids:
        return "the same in every frame"
    if len(ids) == count - 1:
        return "another in every frame"
    shown = ", ".join(ids[:12]) + (" ..." if len(ids) > 12 else "")
    return f"changes at {len(ids)} of {count} frames: {shown}"


def _measures(frames: tuple[FrameMeasures, ...]) -> RenderableType:
    table = Table(box=None, pad_edge=False, header_style="")
    table.add_column("\nper frame")
    for heading in ("\nsmallest", "\nmedian", "\nlargest", "largest\nin frame"):
        table.add_column(heading, justify="right")
    for name, heading, only_if_any in _ROWS:
        values = np.array([getattr(frame, name) for frame in frames])
        if only_if_any and not values.any():
            continue
        worst = frames[int(values.argmax())].id if values.min() < values.max() else ""
        pattern = "{:.0f}" if values.dtype.kind == "i" else "{:.3f}"
        shown = [pattern.format(value) for value in (values.min(), np.median(values), values.max())]
        table.add_row(heading, *(text.replace("-0.000", "0.000") for text in shown), worst)
    absent = [
        heading for name, heading, only_if_any in _ROWS if only_if_any and not any(getattr(f, name) for f in frames)
    ]
    return Group("", table, Text(f"None: {'; '.join(absent)}.") if absent else "", "")


def _faults(inspection: Inspection) -> Table:
    table = Table(box=None, pad_edge=False, header_style="")
    table.add_column("frame", no_wrap=True)
    for heading in ("file", "what is wrong", "what to do"):
        table.add_column(heading, overflow="fold")
    for frame_id, fault in zip(inspection.fault_ids, inspection.faults, strict=True):
        file = fault.file.removeprefix(inspection.folder).lstrip("/\\")
        table.add_row(frame_id, file, fault.fault, fault.remedy)
    return table
