"""Worker processes: everything parallel goes through a ``concurrent.futures.Executor``."""

import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from types import TracebackType
from typing import Any

# Workers are whole processes: more threads inside them would fight over the cores, and sums split over a varying number
# of threads would not repeat.
SINGLE_THREAD = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "VECLIB_MAXIMUM_THREADS": "1",
}


def single_thread() -> None:
    """Keep BLAS to one thread. Works only before NumPy is imported, so it runs first in every worker."""
    os.environ.update(SINGLE_THREAD)


class Pool:
    """So many worker processes of one thread each, replaced as a whole where one of them dies.

    Workers are started afresh, not forked, so that they are alike on every system.
    """

    def __init__(self, workers: int):
        self.workers = workers
        self.executor: Executor = self._start()

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        return self.executor.submit(task, *arguments)

    def restart(self) -> None:
        self.executor.shutdown(wait=False, cancel_futures=True)
        self.executor = self._start()

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.executor.shutdown(wait=error is None, cancel_futures=True)

    def _start(self) -> Executor:
        context = multiprocessing.get_context("spawn")
        return ProcessPoolExecutor(self.workers, mp_context=context, initializer=single_thread)
