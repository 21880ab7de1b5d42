"""Why an artefact is made again: what its manifest was made from, beside what is asked for now."""

from collections.abc import Iterator, Mapping
from typing import Any


def changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """A phrase for every input that differs, in the order of ``now``; inner keys are written with a dot."""
    return list(_differences("", before, now))


def _differences(path: str, before: Any, now: Any) -> Iterator[str]:
    if before == now:
        return
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        for key in [*now, *(key for key in before if key not in now)]:
            inner = f"{path}.{key}" if path else str(key)
            if key not in before:
                yield f"{inner} is new"
            elif key not in now:
                yield f"{inner} is gone"
            else:
                yield from _differences(inner, before[key], now[key])
    elif isinstance(before, list) and isinstance(now, list | tuple):
        yield _of_lists(path, before, list(now))
    else:
        yield f"{path} was {_short(before)} and is {_short(now)}"


def _of_lists(path: str, before: list[Any], now: list[Any]) -> str:
    if len(before) != len(now):
        return f"{path} were {len(before)} and are {len(now)}"
    different = [i for i, (old, new) in enumerate(zip(before, now, strict=True)) if old != new]
    return f"{len(different)} of {len(now)} {path} differ, the first is number {different[0] + 1}"


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
