"""Running a list of tasks in processes or here, with the results in the order of the tasks."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from typing import Any


def run(function: Callable[..., Any], tasks: list[tuple[Any, ...]], executor: Executor | None) -> Iterator[Any]:
    """``function(*task)`` for every task: by the executor's workers, or one after the other where there is none.

    ``function`` is a top-level function and every task picklable.
    """
    if executor is None:
        return (function(*task) for task in tasks)
    return executor.map(function, *zip(*tasks, strict=True)) if tasks else iter(())
