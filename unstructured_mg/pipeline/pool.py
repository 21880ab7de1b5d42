"""Worker processes: everything parallel goes through a ``concurrent.futures.Executor``."""

import multiprocessing
import os
import threading
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
    """Keep BLAS to one thread. Works only before NumPy is imported."""
    os.environ.update(SINGLE_THREAD)


def start_worker() -> None:
    """Runs first in every worker: one thread, and an end when the process that started it is killed."""
    single_thread()
    parent = multiprocessing.parent_process()

    def end_with_parent() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


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
        return ProcessPoolExecutor(self.workers, mp_context=context, initializer=start_worker)
