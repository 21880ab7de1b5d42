"""The quality card of a transition: what a viewer could see, in numbers."""

from collections.abc import Mapping
from typing import Any

import igl.predicates
import numpy as np

from unstructured_mg.geometry.tets import tet_volumes
from unstructured_mg.synthesis.align import vertex_areas
from unstructured_mg.synthesis.contact import planted
from unstructured_mg.synthesis.options import SynthesisOptions
from unstructured_mg.synthesis.posture import Posture


def root_mean_square(vectors: np.ndarray, masses: np.ndarray) -> float:
    """Mass-weighted rms length of ``vectors`` (n, 3)."""
    return float(np.sqrt(masses @ (vectors**2).sum(1) / masses.sum()))


def window_changes(window: np.ndarray, masses: np.ndarray) -> tuple[float, float]:
    """Largest rms change of place and of velocity (metres a frame) inside one tracked window ``(2k+1, n, 3)``."""
    steps = np.diff(window, axis=0)
    speed = max(root_mean_square(step, masses) for step in steps)
    return speed, max((root_mean_square(turn, masses) for turn in np.diff(steps, axis=0)), default=0.0)


def normal_change(window: np.ndarray, faces: np.ndarray) -> float:
    """Largest rms motion (metres a frame) along the normals inside one tracked window ``(2k+1, n, 3)``.

    What ``surface_distance`` would give between neighbours for small motions, at a hundredth of the cost.
    """
    changes = []
    for before, after in zip(window[:-1], window[1:], strict=True):
        a, b, c = (before[faces[:, i]] for i in range(3))
        crosses = np.cross(b - a, c - a)
        areas = np.linalg.norm(crosses, axis=1)
        along = np.einsum("ma,mia->m", crosses, (after - before)[faces]) / np.where(areas > 0, 3 * areas, 1.0)
        changes.append(float(np.sqrt(areas @ along**2 / areas.sum())))
    return max(changes)


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Signed volume of a closed surface, cubic metres."""
    centred = vertices - vertices.mean(0)
    return float(np.einsum("ij,ij->", centred[faces[:, 0]], np.cross(centred[faces[:, 1]], centred[faces[:, 2]])) / 6)


def is_closed(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Whether the faces' area vectors cancel, as those of a closed surface do (seams need not be welded)."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    crosses = np.cross(b - a, c - a)
    return bool(np.linalg.norm(crosses.sum(0)) <= 1e-6 * np.linalg.norm(crosses, axis=1).sum())


def volume_drift(
    steps: list[Posture],
    first: list[Posture],
    second: list[Posture],
    weights: np.ndarray,
    faces: np.ndarray,
    tets: np.ndarray,
) -> float | None:
    """Largest |V / V0 - 1| over the steps, V0 the blend of the two frames' volumes.

    Of the surface where it is closed, otherwise of the cage; None where the surface is open and the blend has no cage.
    """
    closed = is_closed(first[0].surface, faces)
    if not closed and steps[1].cage is None:
        return None

    def measure(posture: Posture) -> float:
        if closed or posture.cage is None:
            return volume(posture.surface, faces)
        return float(tet_volumes(posture.cage, tets).sum())

    drifts = []
    for new, source, target, weight in zip(steps, first, second, weights, strict=True):
        expected = (1 - weight) * measure(source) + weight * measure(target)
        drifts.append(abs(measure(new) / expected - 1))
    return float(max(drifts))


def inverted_tets(steps: list[Posture], first: list[Posture], second: list[Posture], tets: np.ndarray) -> int | None:
    """Largest number of cage cells turned inside out in a step and in neither of its two frames; None without cages."""
    counts = []
    for new, source, target in zip(steps, first, second, strict=True):
        if new.cage is None or source.cage is None or target.cage is None:
            return None
        sound = (tet_volumes(source.cage, tets) > 0) & (tet_volumes(target.cage, tets) > 0)
        counts.append(int((sound & (tet_volumes(new.cage, tets) <= 0)).sum()))
    return max(counts)


def intersecting_share(vertices: np.ndarray, faces: np.ndarray) -> float:
    """Share of faces that cut through another face."""
    _, pairs, _ = igl.predicates.find_self_intersections(
        np.ascontiguousarray(vertices, np.float64), np.ascontiguousarray(faces, np.int64), False
    )
    return len(np.unique(pairs)) / len(faces)


def foot_slide(steps: np.ndarray, first: np.ndarray, second: np.ndarray, masses: np.ndarray) -> float:
    """How far (metres) planted soles slide in the whole transition.

    Summed over the steps: the mean horizontal way of what is planted (see ``contact.planted``). All are
    ``(2k+1, n, 3)``.
    """
    way = 0.0
    for i in range(len(steps) - 1):
        sole = planted(first, second, i)
        if masses[sole].sum() > 0:
            moved = np.linalg.norm(steps[i + 1, :, :2] - steps[i, :, :2], axis=1)
            way += float(masses[sole] @ moved[sole] / masses[sole].sum())
    return way


def quality_card(
    steps: list[Posture],
    first: list[Posture],
    second: list[Posture],
    windows: tuple[np.ndarray, np.ndarray],
    weights: np.ndarray,
    faces: np.ndarray,
    tets: np.ndarray,
    surface_jumps: tuple[float, float],
    surface_change: float,
) -> dict[str, Any]:
    """The card, JSON-ready.

    ``steps``, ``first`` and ``second`` are the ``2k+1`` postures of the transition and of what it is blended from, and
    ``windows`` the surfaces (m, n, 3) of the two windows frame by frame (the same where no frame is held or left out),
    all in one place; ``surface_jumps`` the distances (metres) between the captured and the synthesized frame at the
    start and at the end; ``surface_change`` the capture's own between the neighbours that were read, to which the
    tracked windows' motion along the normals is joined. What colours and textures add comes by ``with_texture``.

    Keys: ``start`` and ``end`` hold, for each seam, ``surface_m``, ``velocity_m`` (a frame), ``colour_levels`` (sRGB
    grey levels) and the ratios ``surface``, ``velocity`` and ``colour`` to the capture's own largest change
    ``surface_change_m``, ``velocity_change_m`` and ``colour_change_levels``; ``speed_m`` the windows' largest rms
    motion a frame; ``volume_drift``, ``inverted_tets``, ``self_intersections`` (share of faces, beyond the worse
    end), ``foot_slide_m``; None where something could not be measured; ``texture`` holds the texture's measures.
    """
    surfaces, first_surfaces, second_surfaces = (
        np.stack([posture.surface for posture in postures]) for postures in (steps, first, second)
    )
    masses = vertex_areas(surfaces[0], faces) + vertex_areas(surfaces[-1], faces)
    before, after = windows
    first_speed, first_turn = window_changes(before, masses)
    second_speed, second_turn = window_changes(after, masses)
    surface_change = max(surface_change, normal_change(before, faces), normal_change(after, faces))
    velocity_change = max(first_turn, second_turn)
    velocity_jumps = (
        root_mean_square((surfaces[1] - surfaces[0]) - (before[1] - before[0]), masses),
        root_mean_square((surfaces[-1] - surfaces[-2]) - (after[-1] - after[-2]), masses),
    )
    shares = [intersecting_share(surfaces[i], faces) for i in (0, len(surfaces) // 2, -1)]
    seams = {
        name: {
            "surface_m": surface_jumps[i],
            "surface": _ratio(surface_jumps[i], surface_change),
            "velocity_m": velocity_jumps[i],
            "velocity": _ratio(velocity_jumps[i], velocity_change),
            "colour_levels": None,
            "colour": None,
        }
        for i, name in enumerate(("start", "end"))
    }
    return {
        **seams,
        "surface_change_m": surface_change,
        "velocity_change_m": velocity_change,
        "colour_change_levels": None,
        "speed_m": max(first_speed, second_speed),
        "volume_drift": volume_drift(steps, first, second, weights, faces, tets),
        "inverted_tets": inverted_tets(steps, first, second, tets),
        "self_intersections": max(0.0, shares[1] - max(shares[0], shares[2])),
        "foot_slide_m": foot_slide(surfaces, first_surfaces, second_surfaces, masses),
        "texture": {},
    }


def with_texture(card: Mapping[str, Any], colour_change: float | None, measures: Mapping[str, Any]) -> dict[str, Any]:
    """The card with the capture's own change of colour (grey levels) and the measures that came with the texture."""
    seams = {}
    for name in ("start", "end"):
        jump = measures.get(f"seam_color_{name}")
        seams[name] = {**card[name], "colour_levels": jump, "colour": _ratio(jump, colour_change)}
    return {**card, **seams, "colour_change_levels": colour_change, "texture": dict(measures)}


def _ratio(jump: float | None, change: float | None) -> float | None:
    """None where nothing was measured, or the capture does not change at all and the jump is without measure."""
    if jump is None or change is None:
        return None
    if change > 0:
        return jump / change
    return 0.0 if jump == 0 else None


def objections(card: Mapping[str, Any], options: SynthesisOptions) -> list[str]:
    """Why a transition with this card is refused: a clause each, none where it is good."""
    found = []
    for seam in ("start", "end"):
        for name, unit in (("surface", "_m"), ("velocity", "_m"), ("colour", "_levels")):
            ratio, size = card[seam][name], card[seam][name + unit]
            bar, floor = getattr(options, f"{name}_jump"), getattr(options, f"{name}_jump_floor")
            if size is not None and size > floor and (ratio is None or ratio > bar):
                shown = f"{1000 * size:.1f} mm" if unit == "_m" else f"{size:.1f} grey levels"
                times = "where the capture is still" if ratio is None else f"{ratio:.2f} times the capture's own change"
                found.append(f"the {name} jumps at its {seam} by {shown}, {times}")
    if card["volume_drift"] is not None and card["volume_drift"] > options.volume_drift:
        found.append(f"the volume drifts by {card['volume_drift']:.1%}")
    if card["inverted_tets"] is not None and card["inverted_tets"] > options.inverted_tets:
        found.append(f"{card['inverted_tets']} cage cells turn inside out")
    if card["self_intersections"] > options.self_intersections:
        found.append(f"{card['self_intersections']:.1%} more of its faces cut through others than at its ends")
    if card["foot_slide_m"] > options.foot_slide:
        found.append(f"planted feet slide by {100 * card['foot_slide_m']:.1f} cm")
    sharpness = card["texture"].get("sharpness")
    if sharpness is not None and sharpness < options.sharpness:
        found.append(f"its middle is {sharpness:.2f} times as sharp as its ends")
    return found
