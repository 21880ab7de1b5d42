"""Damage for files: the same for the same seed, small mostly, and fond of numbers that promise too much."""

import random
import re

# Numbers that size a thing, as text and as bytes of any width.
PROMISES = ("-1", "0", "4294967295", "2147483648", "99999999999999999999", "1e308", "nan", "inf", "-2147483649", "1.5")
WIDTHS = ((1, "little"), (2, "little"), (4, "little"), (8, "little"), (2, "big"), (4, "big"))
VALUES = (0, 1, 2**7, 2**8 - 1, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63)


def mutated(data: bytes, draw: random.Random) -> bytes:
    """One to four damages."""
    for _ in range(draw.choice((1, 1, 1, 2, 3, 4))):
        data = draw.choice((_flip, _number, _binary, _cut, _repeat, _remove, _insert, _swap))(data, draw)
    return data


def _place(data: bytes, draw: random.Random) -> int:
    """Anywhere, but in the head as often as in all the rest."""
    return draw.randrange(max(1, min(len(data), draw.choice((64, 512, len(data) or 1)))))


def _flip(data: bytes, draw: random.Random) -> bytes:
    at = _place(data, draw)
    return data[:at] + bytes(b ^ (1 << draw.randrange(8)) for b in data[at : at + 1]) + data[at + 1 :]


def _number(data: bytes, draw: random.Random) -> bytes:
    """Another number in place of one written out."""
    start = _place(data, draw)
    found = re.compile(rb"-?[0-9]+(\.[0-9]+)?").search(data, start)
    if found is None:
        return _flip(data, draw)
    return data[: found.start()] + draw.choice(PROMISES).encode() + data[found.end() :]


def _binary(data: bytes, draw: random.Random) -> bytes:
    at, (width, order) = _place(data, draw), draw.choice(WIDTHS)
    value = draw.choice(VALUES) % 256**width
    return data[:at] + value.to_bytes(width, order) + data[at + width :]


def _cut(data: bytes, draw: random.Random) -> bytes:
    return data[: _place(data, draw)] if draw.random() < 0.5 else data[: -1 - draw.randrange(64)]


def _repeat(data: bytes, draw: random.Random) -> bytes:
    at, length = _place(data, draw), draw.randrange(1, 65)
    return data[:at] + data[at : at + length] * draw.choice((2, 3, 50)) + data[at + length :]


def _remove(data: bytes, draw: random.Random) -> bytes:
    at = _place(data, draw)
    return data[:at] + data[at + draw.randrange(1, 65) :]


def _insert(data: bytes, draw: random.Random) -> bytes:
    at = _place(data, draw)
    return data[:at] + draw.choice((b"\x00", b"\xff" * 4, b"\n", b"{", b'"', b"/../", b"\\", b" ")) + data[at:]


def _swap(data: bytes, draw: random.Random) -> bytes:
    a, b = sorted((_place(data, draw), _place(data, draw)))
    length = min(32, b - a)
    return data[:a] + data[b : b + length] + data[a + length : b] + data[a : a + length] + data[b + length :]
