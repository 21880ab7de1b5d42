"""Worker processes: everything parallel goes through a ``concurrent.futures.Executor``."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
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


def start_worker(alive: Connection) -> None:
    """Runs first in every worker: one thread, no Ctrl-C, and an end when the pool is killed or its process is.

    Ctrl-C reaches all processes of a terminal; it is for the pool's process to say what follows. Nobody writes to
    ``alive``: it ends when the pool closes the other side.
    """
    single_thread()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def end_with_parent() -> None:
        if parent is not None:
            wait([parent.sentinel, alive])
            os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


class Pool:
    """So many worker processes of one thread each, replaced as a whole where one of them dies.

    Workers are started afresh, not forked, so that they are alike on every system.
    """

    def __init__(self, workers: int):
        self.workers = workers
        self._alive, self._hold = multiprocessing.get_context("spawn").Pipe(duplex=False)
        self.executor: Executor = self._start()

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Start a task. Where a worker has died unnoticed, the future says so, as those before it do."""
        try:
            return self.executor.submit(task, *arguments)
        except BrokenProcessPool as error:
            future: Future[Any] = Future()
            future.set_exception(error)
            return future

    def restart(self) -> None:
        self.executor.shutdown(wait=False, cancel_futures=True)
        self.executor = self._start()

    def kill(self) -> None:
        """End all workers in the middle of their work, and return when they are gone."""
        self._hold.close()
        self.executor.shutdown(wait=True, cancel_futures=True)

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if error is None:
            self.executor.shutdown()
        self.kill()
        self._alive.close()

    def _start(self) -> Executor:
        return _Executor(
            self.workers,
            mp_context=multiprocessing.get_context("spawn"),
            initializer=start_worker,
            initargs=(self._alive,),
        )


class _Executor(ProcessPoolExecutor):
    """Workers are started by ``submit``, where and when the executor needs one more."""

    def submit(self, task: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future[Any]:
        with _interrupts_held():
            return super().submit(task, *arguments, **options)


@contextmanager
def _interrupts_held() -> Iterator[None]:
    """Processes that are started in this block never see Ctrl-C, not even while they import; this one does, later."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker  # not on Windows

    # The tracker, where multiprocessing starts it in the block, lets interrupts through again.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
