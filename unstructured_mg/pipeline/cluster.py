"""Workers of a Dask cluster (``pip install 'unstructured_mg[cluster]'``), over a folder that all of them see."""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from pathlib import Path
from types import TracebackType
from typing import Any

from unstructured_mg import __version__
from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.pool import SINGLE_THREAD

# Seconds to wait for the scheduler's answer.
PATIENCE = 20
# How many times a task is given to another worker when one dies with it.
RETRIES = 3


class ClusterPool:
    """The workers of the Dask scheduler at ``address``, however many there are at the moment.

    Dask gives what a dead worker was doing to another one, and waits for new ones where none is left. Raises UserError
    where there is no scheduler or its workers cannot do the work.
    """

    def __init__(self, address: str):
        try:
            from distributed import Client
        except ImportError:
            raise UserError("--dask: needs Dask; install it with pip install 'unstructured_mg[cluster]'.") from None
        self.address = address
        try:
            self._client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise UserError(f"{address}: there is no Dask scheduler that answers ({reason}); see --dask.") from None
        self.executor: Executor = _ClusterExecutor(self._client, address)

    @property
    def workers(self) -> int:
        return max(1, sum(self._client.nthreads().values()))

    def check(self, folder: Path) -> None:
        """Whether every worker has this program's version, one thread for its sums, and sees ``folder``."""
        found = self._client.run(describe_worker, str(folder.resolve()))
        if not found:
            raise UserError(
                f"{self.address}: the scheduler has no workers; start some with dask worker {self.address}."
            )
        for worker, (version, threads, sees) in sorted(found.items()):
            if version != __version__:
                raise UserError(
                    f"{worker}: has version {version} of unstructured_mg, not {__version__}; install the same."
                )
            if not sees:
                raise UserError(f"{worker}: does not see {folder}; put it on a disk that all workers share.")
            if threads:
                raise UserError(
                    f"{worker}: lets {threads[0]} be {threads[1]}, and its threads would fight over the cores; "
                    f"start it with {threads[0]}=1."
                )

    def submit(self, task: Callable[..., Any], *arguments: Any) -> Future[Any]:
        return self.executor.submit(task, *arguments)

    def restart(self) -> None:
        """Nothing to do: Dask has taken care of the dead worker."""

    def kill(self) -> None:
        """Forget all tasks. Workers end what they are doing; nobody takes it from them."""
        self.executor.shutdown(wait=False)
        self._client.close()

    def __enter__(self) -> "ClusterPool":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.kill()


def describe_worker(folder: str) -> tuple[str, tuple[str, str] | None, bool]:
    """Of the process that this runs in: the program's version, what lets it use several threads, whether it sees
    ``folder``.
    """
    loose = [(name, os.environ.get(name, "unset")) for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")]
    return __version__, next((each for each in loose if each[1] != SINGLE_THREAD[each[0]]), None), os.path.isdir(folder)


class _ClusterExecutor(Executor):
    """Dask's executor, whose dead workers are told as those of processes are."""

    def __init__(self, client: Any, address: str):
        # pure=False: what failed is to be done again, not remembered.
        self._inner = client.get_executor(pure=False, retries=RETRIES)
        self._address = address

    def submit(self, task: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future[Any]:
        inner = self._inner.submit(task, *arguments, **options)
        outer: Future[Any] = Future()
        outer.set_running_or_notify_cancel()

        def pass_on(done: Future[Any]) -> None:
            error = None if done.cancelled() else done.exception()
            if done.cancelled() or error is not None:
                outer.set_exception(self._told(error))
            else:
                outer.set_result(done.result())

        inner.add_done_callback(pass_on)
        return outer

    def map(self, fn: Callable[..., Any], *iterables: Any, **options: Any) -> Iterator[Any]:  # type: ignore[override]
        futures = [self.submit(fn, *arguments) for arguments in zip(*iterables, strict=False)]
        return (future.result() for future in futures)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._inner.shutdown(wait=wait and not cancel_futures)

    def _told(self, error: BaseException | None) -> BaseException:
        from distributed import KilledWorker

        if error is None:
            return UserError(f"{self._address}: the scheduler is gone; start it and run the same command again.")
        return BrokenExecutor(str(error)) if isinstance(error, KilledWorker) else error
