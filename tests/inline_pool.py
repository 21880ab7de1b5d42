"""A pool without processes: every task runs at once, where it is submitted."""

from concurrent.futures import Executor, Future
from types import TracebackType
from typing import Any


class InlineExecutor(Executor):
    def submit(self, task: Any, /, *arguments: Any, **options: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(task(*arguments, **options))
        except BaseException as error:
            future.set_exception(error)
        return future


class InlinePool:
    workers = 1

    def __init__(self) -> None:
        self.executor = InlineExecutor()
        self.submit = self.executor.submit

    def restart(self) -> None: ...

    def kill(self) -> None: ...

    def __enter__(self) -> "InlinePool":
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None: ...
