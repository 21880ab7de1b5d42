"""One writer a work folder."""

import os
import sys
from pathlib import Path
from types import TracebackType

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.store import user_errors


class FolderLock:
    """Hold ``folder/lock`` for this process. The system frees it when the process ends, however it ends."""

    def __init__(self, folder: Path):
        self.path = folder / "lock"
        self._descriptor: int | None = None

    def __enter__(self) -> "FolderLock":
        with user_errors(self.path):
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            _lock(descriptor)
        except OSError:
            holder = os.read(descriptor, 100).decode(errors="replace").strip()
            os.close(descriptor)
            who = f" (process {holder})" if holder else ""
            raise UserError(
                f"{self.path.parent}: another umg{who} is writing this folder; wait for it, or choose another."
            ) from None
        os.ftruncate(descriptor, 0)
        os.write(descriptor, str(os.getpid()).encode())
        self._descriptor = descriptor
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._descriptor is not None:
            os.ftruncate(self._descriptor, 0)
            os.close(self._descriptor)
            self._descriptor = None


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        # A byte beyond the text, so that the holder's number stays readable.
        os.lseek(descriptor, 1000, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)

else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
