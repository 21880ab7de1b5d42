"""How long work tells how far it has come."""

from collections.abc import Callable

# Called with (items done, items in all), never from a worker.
Progress = Callable[[int, int], None]
