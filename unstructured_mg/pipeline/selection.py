"""The greedy choice of pairs (P section 4): try the best, on refusal let a near one be tried, never two near ones kept.

The choice is the one that a single worker would make in ranked order. Workers may run ahead; what they did counts only
when its turn comes, so the result does not depend on how many there are.
"""

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

Item = TypeVar("Item")


class GreedySelection(Generic[Item]):
    """Decide ranked ``items`` in order.

    Parameters
    ----------
    items : best first
    is_near : whether an item is too close to one of a list of others
    retries : how many refused items near an item rule it out
    limit : how many to accept at most, or None
    """

    def __init__(
        self, items: Sequence[Item], is_near: Callable[[Item, list[Item]], bool], retries: int, limit: int | None = None
    ):
        self.items = items
        self.accepted: list[Item] = []
        self.refused: list[Item] = []
        self._is_near = is_near
        self._retries = retries
        self._limit = limit
        self._results: dict[int, bool] = {}
        self._started: set[int] = set()
        self._turn = 0

    @property
    def finished(self) -> bool:
        self._advance()
        return self._turn >= len(self.items)

    @property
    def decided(self) -> int:
        """How many of the items have been decided."""
        self._advance()
        return self._turn

    def next(self) -> int | None:
        """The index of an item worth starting now, or None. It counts as started from here on."""
        self._advance()
        running = [self.items[i] for i in sorted(self._started) if i >= self._turn]
        for i in range(self._turn, len(self.items)):
            if i in self._started or self._ruled_out(self.items[i]):
                continue
            # Running ahead of one whose near and better neighbour is still on trial would likely be for nothing.
            if i == self._turn or not self._is_near(self.items[i], running):
                self._started.add(i)
                return i
        return None

    def report(self, index: int, accepted: bool) -> None:
        """Tell how the trial of item ``index`` ended."""
        self._results[index] = accepted

    def _ruled_out(self, item: Item) -> bool:
        if self._limit is not None and len(self.accepted) >= self._limit:
            return True
        if self._is_near(item, self.accepted):
            return True
        return sum(self._is_near(item, [other]) for other in self.refused) >= self._retries

    def _advance(self) -> None:
        while self._turn < len(self.items):
            item = self.items[self._turn]
            if not self._ruled_out(item):
                if self._turn not in self._results:
                    return
                (self.accepted if self._results[self._turn] else self.refused).append(item)
            self._turn += 1
