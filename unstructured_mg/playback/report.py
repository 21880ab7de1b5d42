"""``umg report``: one HTML file that needs nothing beside it, neither a server nor scripts nor a connection."""

import json
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from importlib import resources
from pathlib import Path

import numpy as np

from unstructured_mg.matching.candidates import Candidate
from unstructured_mg.playback.pictures import Picture, Seam, TransitionPictures
from unstructured_mg.playback.plot_matrix import plot_matrix
from unstructured_mg.playback.plot_timeline import plot_timeline
from unstructured_mg.playback.plot_visits import plot_visits
from unstructured_mg.playback.quality import plain_rows, quality_rows
from unstructured_mg.playback.report_data import PairOutcome, ReportData, TransitionEntry
from unstructured_mg.playback.svg import apart, data_uri, length, number, percent
from unstructured_mg.playback.whole_file import whole_file

# Pixels: the playing film beside the tables.
FILM_WIDTH = 170


def write_report(data: ReportData, out: Path) -> None:
    """Write the report to the file ``out``, whole or not at all. Pictures are asked for one transition at a time."""
    with whole_file(out) as file:
        for part in _page(data):
            file.write(part.encode())


def _page(data: ReportData) -> Iterator[str]:
    style = resources.files("unstructured_mg.playback").joinpath("report.css").read_text(encoding="utf-8")
    yield (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(data.title)}</title>\n<style>\n{style}</style>\n</head>\n<body>\n"
    )
    yield _top(data)
    yield f'<main>\n<h1>{escape(data.title)}</h1>\n<p class="lead">{escape(_lead(data))}</p>\n'
    yield _tiles(data)
    yield _capture(data)
    yield _tables(data)
    yield _matching(data)
    yield _timeline(data)
    yield _visits(data)
    yield from _transitions(data)
    yield _refused(data)
    yield _without_candidates(data)
    yield _choosing(data)
    made = f"unstructured_mg {data.version}".strip()
    yield f"<footer>Made by {escape(made)}.</footer>\n</main>\n</body>\n</html>\n"


def _kept(data: ReportData) -> list[PairOutcome]:
    return [pair for pair in data.pairs if pair.status == "kept"]


def _refusals(data: ReportData) -> list[PairOutcome]:
    return [pair for pair in data.pairs if pair.status != "kept"]


def _top(data: ReportData) -> str:
    links = [("Capture", "capture"), ("Matching", "matching")]
    if data.covered is not None:
        links.append(("Graph", "graph"))
    if data.transitions:
        links.append(("Transitions", "transitions"))
    if _refusals(data):
        links.append(("Refused", "refused"))
    if data.pairs:
        links.append(("Choose", "choosing"))
    items = "".join(f'<a href="#{anchor}">{name}</a>' for name, anchor in links)
    speed = ""
    if data.transitions:
        choices = [("full", "full"), ("half", "half"), ("quarter", "quarter"), ("still", "still")]
        speed = '<fieldset class="speed"><legend>Speed</legend>' + "".join(
            f'<label><input type="radio" name="speed" id="{key}"{" checked" if key == "half" else ""}>{text}</label>'
            for key, text in choices
        )
        speed += "</fieldset>"
    return f'<div class="top"><div>{items}{speed}</div></div>\n'


def _lead(data: ReportData) -> str:
    frames = len(data.capture)
    if not data.pairs and not data.candidates:
        return f"{_count(frames, 'captured frame')}; no two windows are alike enough for a transition."
    kept = len(_kept(data))
    text = f"{_count(frames, 'captured frame')}, {_count(len(data.candidates), 'candidate pair')}, {kept} kept"
    if data.covered is not None:
        played = sum(entry.in_graph for entry in data.transitions)
        text += f": a graph of {_count(int(data.covered.sum()), 'frame')} and {_count(played, 'transition')}"
    return text + "."


def _count(count: int, noun: str) -> str:
    return f"{count} {noun}" + ("" if count == 1 else "s")


def _tiles(data: ReportData) -> str:
    frames = len(data.capture)
    tiles = [("frames captured", str(frames), "")]
    if data.covered is not None:
        covered = int(data.covered.sum())
        tiles.append(("frames in the graph", str(covered), f" {100 * covered / max(frames, 1):.0f} %"))
    tiles.append(("candidate pairs", str(len(data.candidates)), ""))
    tiles.append(("pairs refused", str(len(_refusals(data))), ""))
    tiles.append(("pairs kept", str(len(_kept(data))), ""))
    if data.stage_minutes:
        tiles.append(("minutes", _minutes(sum(minutes for _, minutes in data.stage_minutes)), ""))
    items = "".join(
        f"<div><dt>{name}</dt><dd>{value}{f'<small>{extra}</small>' if extra else ''}</dd></div>"
        for name, value, extra in tiles
    )
    return f'<dl class="tiles">{items}</dl>\n'


def _capture(data: ReportData) -> str:
    rows = [[_cell(label, "th"), _cell(value)] for label, value in data.capture_summary]
    parts = ['<h2 id="capture">Capture</h2>\n<div class="card">', f'<div class="facts">{_table("", [], rows)}</div>']
    if data.capture.warnings:
        sentences = "".join(f"<li>{escape(warning)}</li>" for warning in data.capture.warnings)
        parts.append(f'<h3>Assumed</h3><ul class="warnings">{sentences}</ul>')
    if data.capture.faults:
        faults = [[_cell(fault.file, "th"), _cell(fault.fault), _cell(fault.remedy)] for fault in data.capture.faults]
        title = f"{_count(len(faults), 'frame')} could not be used"
        head = [_cell(name, "th") for name in ("file", "fault", "remedy")]
        parts.append(f'<div class="faults">{_table(title, head, faults)}</div>')
    return "".join(parts) + "</div>\n"


def _tables(data: ReportData) -> str:
    """The tables of P: what went in and came out (Table 1), and the minutes of each stage (Table 2)."""
    counts = [
        ("frames captured", len(data.capture)),
        ("candidate pairs", len(data.candidates)),
        ("pairs tried", len(data.pairs)),
        ("pairs refused", len(_refusals(data))),
        ("pairs kept", len(_kept(data))),
        ("transitions made", len(data.transitions)),
    ]
    if data.covered is not None:
        counts.append(("transitions in the graph", sum(entry.in_graph for entry in data.transitions)))
        counts.append(("frames in the graph", int(data.covered.sum())))
    first = _table("In and out", [], [[_cell(name, "th"), _figure(str(count))] for name, count in counts])
    if not data.stage_minutes:
        return f'<h2 id="summary">Summary</h2>\n<div class="card">{first}</div>\n'
    total = sum(minutes for _, minutes in data.stage_minutes)
    rows = [[_cell(stage, "th"), _figure(_minutes(minutes))] for stage, minutes in data.stage_minutes]
    second = _table("Minutes", [], rows, foot=[_cell("total", "th"), _figure(_minutes(total))])
    return (
        '<h2 id="summary">Summary</h2>\n<div class="columns">'
        f'<div class="card">{first}</div><div class="card">{second}</div></div>\n'
    )


def _matching(data: ReportData) -> str:
    if data.scores is None:
        return '<h2 id="matching">Matching</h2>\n<p>There is no matching result yet.</p>\n'
    plot = plot_matrix(data.capture, data.scores, data.unit, data.threshold, data.gap, data.pairs)
    key = []
    if _kept(data):
        key.append('<li><i class="ring"></i>kept</li>')
    if _refusals(data):
        key.append('<li><i class="cross">×</i>refused</li>')
    key.append('<li><i class="pointer"></i>threshold</li>')
    key.append(f"<li>between the dashed lines: less than {_count(data.gap, 'frame')} apart, not considered</li>")
    return (
        '<h2 id="matching">Matching</h2>\n<p>How far apart the surfaces around each two frames are, at the best turn '
        "of the figure. Dark valleys away from the diagonal are moments that resemble each other; pairs up to "
        f"{apart(data.threshold, data.unit)} are candidates.</p>"
        f'<div class="card matching"><figure>{plot}<ul class="key">{"".join(key)}</ul></figure>'
        f"<div>{_nearest(data)}</div></div>\n"
    )


def _timeline(data: ReportData) -> str:
    if not data.transitions:
        return ""
    plot = plot_timeline(data.capture, data.covered, data.transitions)
    return (
        '<h2 id="graph">Graph</h2>\n<p>Each arc is a synthesized transition between two captured frames: forward in '
        "time above the frames, back below. Strong frames belong to the graph: a walk can go on from each of them for "
        "ever.</p>"
        f'<div class="card"><div class="scroll">{plot}</div></div>\n'
    )


def _visits(data: ReportData) -> str:
    notes = "".join(f"<p>{escape(note)}</p>" for note in data.notes)
    if data.covered is None or data.visiting_before is None or data.visiting_after is None:
        return notes
    frames = int(data.covered.sum())
    before, after = (
        float(np.abs(visits[data.covered] * frames - 1).mean())
        for visits in (data.visiting_before, data.visiting_after)
    )
    plot = plot_visits(data.capture, data.covered, data.visiting_before, data.visiting_after)
    return (
        "<h3>Visits</h3><p>How often an endless random walk shows each captured frame, in multiples of an even share. "
        f"The mean distance from an even share is {percent(before)} with even choices and {percent(after)} with the "
        f"chosen probabilities.</p>{notes}"
        f'<div class="card"><div class="scroll">{plot}</div><ul class="key">'
        '<li><i style="color:var(--accent)" class="dash"></i>even share</li>'
        '<li><i style="color:var(--made)"></i>even choices</li>'
        '<li><i style="color:var(--ink)"></i>chosen probabilities</li></ul></div>\n'
    )


def _transitions(data: ReportData) -> Iterator[str]:
    if not data.transitions:
        return
    yield (
        '<h2 id="transitions">Transitions</h2>\n<p>Captured frames stand left and right of the orange lines, '
        "synthesized ones between them, all in the place of the transition's first frame and seen by one camera. The "
        "heat maps show what changes across a seam, and beside it what changes between the captured frames that follow "
        "each other there: a good seam is no brighter. In the tables × stands for times the capture's own change.</p>\n"
    )
    outcomes = {(pair.candidate.source, pair.candidate.target): pair for pair in data.pairs}
    by_pair: dict[tuple[int, int], list[TransitionEntry]] = {}
    for entry in data.transitions:
        first, second = sorted((entry.source, entry.target))
        by_pair.setdefault((first, second), []).append(entry)
    for key in [key for key in outcomes if key in by_pair] + [key for key in by_pair if key not in outcomes]:
        yield _pair_head(data, key, outcomes.get(key))
        for entry in by_pair[key]:
            yield _way(data, entry)
        yield "</article>\n"


def _pair_head(data: ReportData, key: tuple[int, int], outcome: PairOutcome | None) -> str:
    source, target = (escape(data.capture.frame_id(index)) for index in key)
    text = "" if outcome is None else _candidate_numbers(data, outcome.candidate)
    return (
        f'<article class="card pair" id="pair-{key[0]}-{key[1]}"><h3>Frames {source} and {target}</h3>'
        f'<p class="numbers">{text}</p>'
    )


def _candidate_numbers(data: ReportData, candidate: Candidate) -> str:
    return f"{apart(candidate.score, data.unit)} apart, turned by {_degrees(candidate.yaw)}"


def _way(data: ReportData, entry: TransitionEntry) -> str:
    name = data.capture.frame_id
    badge = (
        '<span class="badge good">in the graph</span>'
        if entry.in_graph
        else '<span class="badge">outside the graph</span>'
    )
    shift = float(np.hypot(entry.alignment.x, entry.alignment.y))
    pictures = data.pictures(entry.source, entry.target)
    return (
        f'<section class="way"><h4>{escape(name(entry.source))} to {escape(name(entry.target))} {badge}</h4>'
        f'<p class="numbers">leaves at frame {escape(name(entry.leaves))}, {2 * entry.k - 1} synthesized '
        f"frames, arrives at frame {escape(name(entry.arrives))}; cost {number(entry.cost)}; the target is "
        f"turned by {_degrees(entry.alignment.yaw)} and moved by {length(shift)}</p>"
        f'<div class="play">{_film(pictures)}{_quality(data, entry)}</div>{_sheet(pictures)}'
        f'<div class="seams">{_seam("First seam", pictures.start)}{_seam("Last seam", pictures.end)}</div></section>\n'
    )


def _quality(data: ReportData, entry: TransitionEntry) -> str:
    """What is judged in one table, the other numbers of the card in another."""
    judged, others = [], []
    for row in quality_rows(entry.card, data.limits):
        cells = [_cell(row.name, "th"), _figure(row.value)]
        if row.verdict:
            judged.append([*cells, _figure(row.limit), f'<td class="figure {row.verdict}">{row.verdict}</td>'])
        else:
            others.append(cells)
    head = [_cell("quality", "th"), *(_figure(name, "th") for name in ("value", "limit", "verdict"))]
    tables = [_table("", head, judged)] if judged else []
    if others:
        tables.append(_table("", [_cell("other measures", "th"), _figure("value", "th")], others))
    return '<div class="measures">' + "".join(f'<div class="scroll">{table}</div>' for table in tables) + "</div>"


def _film(pictures: TransitionPictures) -> str:
    frames = pictures.film_frames
    first, last = pictures.film_steps
    width = min(pictures.film.width // frames, FILM_WIDTH)
    inside = f"left:{100 * first / frames:.3f}%;width:{100 * (last - first + 1) / frames:.3f}%"
    return (
        f'<figure style="width:{width}px;max-width:100%;--film:{frames / pictures.fps:.4f}s;--frames:{frames}">'
        f'<div class="film">{_image(pictures.film, "The transition, playing", f"width:{100 * frames}%")}</div>'
        f'<div class="track"><i style="{inside}"></i><div class="head"></div></div>'
        "<figcaption>blue: captured, orange: synthesized</figcaption></figure>"
    )


def _sheet(pictures: TransitionPictures) -> str:
    labels = "".join(f'<b class="{column.kind}">{escape(column.label)}</b>' for column in pictures.columns)
    alternative = f"Contact sheet of the transition from frame {pictures.source} to frame {pictures.target}"
    return (
        f'<div class="scroll"><figure class="sheet"><div class="labels">{labels}</div>'
        f"{_image(pictures.sheet, alternative)}</figure></div>"
    )


def _seam(title: str, seam: Seam) -> str:
    labels = "".join(f"<span>{escape(label)}</span>" for label in seam.labels)
    return (
        f'<figure class="seam"><div class="labels">{labels}</div>{_image(seam.picture, title)}'
        f"<figcaption>{title}: mean change of {number(seam.change)} levels of 255, in the capture "
        f"{number(seam.own_change)}</figcaption></figure>"
    )


def _image(picture: Picture, alternative: str, style: str = "") -> str:
    extra = f' style="{style}"' if style else ""
    return (
        f'<img src="{data_uri(picture.data, "image/jpeg")}" width="{picture.width}" height="{picture.height}" '
        f'alt="{escape(alternative)}" loading="lazy"{extra}>'
    )


def _refused(data: ReportData) -> str:
    refusals = _refusals(data)
    if not refusals:
        return ""
    cards = []
    for pair in refusals:
        rows = [[_cell(row.name, "th"), _figure(row.value)] for row in plain_rows(pair.measures)]
        numbers = f'<p class="numbers">{_candidate_numbers(data, pair.candidate)}; refused in {escape(pair.stage)}</p>'
        table = f"<details><summary>numbers</summary>{_table('', [], rows)}</details>" if rows else ""
        anchor = f"pair-{pair.candidate.source}-{pair.candidate.target}"
        cards.append(_pair_card(data, pair.candidate, f"<p>{escape(pair.reason)}</p>{numbers}{table}", anchor))
    return f'<h2 id="refused">Refused pairs</h2>\n<div class="pairs">{"".join(cards)}</div>\n'


def _nearest(data: ReportData) -> str:
    if not data.nearest:
        return "<p>The capture is too short for two windows.</p>"
    tried = {(pair.candidate.source, pair.candidate.target): pair.status for pair in data.pairs}
    rows = [
        [
            _cell(_pair_name(data, candidate), "th"),
            _figure(apart(candidate.score, data.unit)),
            _figure(_degrees(candidate.yaw)),
            _cell(tried.get((candidate.source, candidate.target), "")),
        ]
        for candidate in data.nearest
    ]
    head = [_cell("frames", "th"), *(_figure(name, "th") for name in ("apart", "turned by")), _cell("", "th")]
    return f'<div class="scroll">{_table("Nearest pairs", head, rows)}</div>'


def _without_candidates(data: ReportData) -> str:
    """What comes nearest, as pictures, where no pair is a candidate."""
    if data.candidates or not data.nearest or data.pair_picture is None:
        return ""
    cards = "".join(
        _pair_card(
            data,
            candidate,
            f"<p>{apart(candidate.score, data.unit)} apart, turned by {_degrees(candidate.yaw)}</p>",
            f"nearest-{candidate.source}-{candidate.target}",
        )
        for candidate in data.nearest
    )
    threshold = apart(data.threshold, data.unit)
    return (
        f'<h2 id="nearest">Nearest pairs</h2>\n<p>No pair comes within the threshold of {threshold}. '
        f'These come nearest.</p><div class="pairs">{cards}</div>\n'
    )


def _choosing(data: ReportData) -> str:
    """How the user overrules the choice of pairs: the pairs that were tried as pairs.json writes them, to copy from."""
    if not data.pairs:
        return ""
    names = [
        json.dumps([data.capture.frame_id(i) for i in (p.candidate.source, p.candidate.target)]) for p in data.pairs
    ]
    example = f'{{"pins": [], "vetoes": [{names[0]}]}}'
    tried = "\n".join(f"{name}  {pair.status}" for name, pair in zip(names, data.pairs, strict=True))
    return (
        '<h2 id="choosing">Choose pairs yourself</h2>\n<div class="card"><p>Write a file <code>pairs.json</code> into '
        "the work folder and run the same <code>umg build</code> again: what is finished is kept. A vetoed pair counts "
        "as refused, and another near it is tried in its place. A pinned pair is tried before all others, however "
        f"unlike its frames are; it may still be refused.</p><pre>{escape(example)}</pre>"
        f"<details><summary>the pairs that were tried</summary><pre>{escape(tried)}</pre></details></div>\n"
    )


def _pair_card(data: ReportData, candidate: Candidate, text: str, anchor: str) -> str:
    name = _pair_name(data, candidate)
    picture = "" if data.pair_picture is None else _image(data.pair_picture(candidate), f"Frames {name}")
    return f'<div class="card" id="{anchor}">{picture}<h3>Frames {escape(name)}</h3>{text}</div>'


def _pair_name(data: ReportData, candidate: Candidate) -> str:
    return f"{data.capture.frame_id(candidate.source)} and {data.capture.frame_id(candidate.target)}"


def _degrees(radians: float) -> str:
    turned = (np.degrees(radians) + 180) % 360 - 180
    return f"{turned:.1f}°".replace("-", "−")


def _minutes(minutes: float) -> str:
    return f"{minutes:.2f}" if minutes < 10 else f"{minutes:.1f}"


def _cell(text: str, tag: str = "td") -> str:
    return f"<{tag}>{escape(text)}</{tag}>"


def _figure(text: str, tag: str = "td") -> str:
    return f'<{tag} class="figure">{escape(text)}</{tag}>'


def _table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]], foot: Sequence[str] = ()) -> str:
    """A table of ready cells."""
    return (
        "<table>"
        + (f"<caption>{escape(caption)}</caption>" if caption else "")
        + (f"<thead><tr>{''.join(head)}</tr></thead>" if head else "")
        + "<tbody>"
        + "".join(f"<tr>{''.join(row)}</tr>" for row in rows)
        + "</tbody>"
        + (f"<tfoot><tr>{''.join(foot)}</tr></tfoot>" if foot else "")
        + "</table>"
    )
