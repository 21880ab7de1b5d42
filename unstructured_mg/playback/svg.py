"""Pieces that the report's hand-made SVG plots share. Colours come from the page's style sheet, through classes."""

import base64
import math
from html import escape


def number(value: float) -> str:
    """A figure as people read it: whole numbers as they are, others with four significant digits."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if not math.isfinite(value):
        return "none" if math.isnan(value) else ("∞" if value > 0 else "−∞")
    text = f"{value:.4g}"
    return text.replace("-", "−", 1) if text.startswith("-") else text


def length(metres: float) -> str:
    """Metres as people say them: millimetres below one metre, to a tenth below ten centimetres."""
    size = abs(metres)
    if not math.isfinite(metres) or size >= 0.9995:
        return f"{number(float(metres))} m"
    text = f"{1000 * metres:.0f}" if size >= 0.09995 else f"{1000 * metres:.1f}".removesuffix(".0")
    return f"{text} mm".replace("-", "−", 1)


def apart(score: float, unit: str) -> str:
    """A dissimilarity in the unit of its descriptor: metres as people say them, angles in degrees, or a number."""
    if unit == "m":
        return length(score)
    return f"{math.degrees(score):.3g}°" if unit == "rad" else f"{score:.3g}"


def percent(share: float) -> str:
    """A share of one in percent, with three significant digits."""
    return f"{100 * share:.3g} %".replace("-", "−", 1)


def at(value: float) -> str:
    """A coordinate: two decimals are a fiftieth of a pixel on a large screen."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


def label(x: float, y: float, text: str, kind: str = "tick", anchor: str = "middle") -> str:
    return f'<text class="{kind}" x="{at(x)}" y="{at(y)}" text-anchor="{anchor}">{escape(text)}</text>'


def line(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    return f'<line class="{kind}" x1="{at(x1)}" y1="{at(y1)}" x2="{at(x2)}" y2="{at(y2)}"/>'


def data_uri(data: bytes, media: str) -> str:
    return f"data:{media};base64,{base64.b64encode(data).decode()}"


def figure(width: float, height: float, title: str, parts: list[str]) -> str:
    """An inline ``svg`` element that scales with the page and tells screen readers what it shows."""
    return (
        f'<svg class="plot" viewBox="0 0 {at(width)} {at(height)}" role="img" aria-label="{escape(title)}">'
        + "".join(parts)
        + "</svg>"
    )


def round_steps(highest: float, about: int) -> list[float]:
    """Multiples of 1, 2 or 5 times a power of ten, from 0 up to ``highest``, about so many."""
    if not highest > 0:
        return [0.0]
    size = 10.0 ** math.floor(math.log10(highest / about))
    step = next((m * size for m in (1, 2, 5) if m * size * (about + 1) > highest), 10 * size)
    return [step * i for i in range(int(highest / step * (1 + 1e-9)) + 1)]
