"""One writer a work folder, on one machine and on a shared disk.

The holder keeps a system lock on ``folder/lock``, which the system frees when the process ends, however it ends.
Between machines that cannot be relied on: some shared disks keep such locks to each machine, or know none. So the file
also says who holds it, with a count that the holder raises every few seconds. Whoever finds another machine's name
there watches the count: while it rises the folder is in use, and when it stands still the holder is gone. No clocks are
compared.
"""

import errno
import json
import os
import socket
import sys
import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.store import user_errors

# Seconds between two counts, and how long a count must stand still: longer than a shared disk takes to tell others.
BEAT = 5.0
PATIENCE = 30.0
# What a disk says that has no locks.
UNKNOWN = (errno.ENOLCK, errno.ENOSYS, errno.ENOTSUP, errno.EINVAL)
# What is written has this length, padded, so that it is replaced in one write and needs no space on a full disk.
LENGTH = 400


class FolderLock:
    """Hold ``folder/lock`` for this process. Raises UserError where another umg holds it.

    Parameters
    ----------
    beat, patience : seconds between two counts; seconds for which another machine's count must stand still
    """

    def __init__(self, folder: Path, beat: float = BEAT, patience: float = PATIENCE):
        self.path = folder / "lock"
        self._beat = beat
        self._patience = patience
        self._descriptor: int | None = None
        self._ended = threading.Event()
        self._lost = False

    def check(self) -> None:
        """Raise UserError where another machine took the folder over, having seen no sign of this one."""
        if self._lost:
            raise UserError(
                f"{self.path.parent}: another machine took this folder over while this one stood still; "
                "finished work is kept there."
            )

    def __enter__(self) -> "FolderLock":
        with user_errors(self.path):
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            self._take(descriptor)
        except BaseException:
            os.close(descriptor)
            raise
        self._descriptor = descriptor
        threading.Thread(target=self._count, daemon=True).start()
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._ended.set()
        if self._descriptor is not None:
            if not self._lost:
                os.ftruncate(self._descriptor, 0)
            os.close(self._descriptor)
            self._descriptor = None

    def _take(self, descriptor: int) -> None:
        alone = True
        try:
            _lock(descriptor)
        except OSError as error:
            if error.errno not in UNKNOWN:
                raise self._in_use(_read(descriptor)) from None
            alone = False
        found = _read(descriptor)
        if found and (not alone or found.get("machine") != _machine()):
            # Its system lock may not reach this one.
            limit = time.monotonic() + self._patience
            while time.monotonic() < limit:
                time.sleep(min(1.0, self._patience / 10))
                if _read(descriptor) != found:
                    raise self._in_use(_read(descriptor))
        self._mine = {"process": os.getpid(), "host": socket.gethostname(), "machine": _machine()}
        with user_errors(self.path):
            _write(descriptor, {**self._mine, "count": 0})

    def _in_use(self, holder: dict[str, Any]) -> UserError:
        who = f" ({_describe(holder)})" if holder else ""
        return UserError(
            f"{self.path.parent}: another umg{who} is writing this folder; wait for it, or choose another."
        )

    def _count(self) -> None:
        count = 0
        while not self._ended.wait(self._beat):
            descriptor = self._descriptor
            if descriptor is None:
                return
            try:
                found = _read(descriptor)
                if found and {**found, "count": 0} != {**self._mine, "count": 0}:
                    self._lost = True
                    return
                count += 1
                _write(descriptor, {**self._mine, "count": count})
            except OSError:
                continue  # a disk that is away for a moment: the next count may get through


def lock_holder(folder: Path) -> str | None:
    """Who is writing in ``folder`` as far as this machine can tell at once, or None."""
    try:
        descriptor = os.open(folder / "lock", os.O_RDWR)
    except OSError:
        return None
    try:
        found = _read(descriptor)
        try:
            _lock(descriptor)
        except OSError:
            return _describe(found) if found else "another umg"
        return _describe(found) if found and found.get("machine") != _machine() else None
    finally:
        os.close(descriptor)


def _machine() -> str:
    """This machine, and since when it runs, as far as the system tells: containers and clones share host names."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text().strip()
    except OSError:
        boot = ""
    return f"{socket.gethostname()} {boot}".strip()


def _describe(holder: dict[str, Any]) -> str:
    process, host = holder.get("process"), holder.get("host")
    return f"process {process}" + (f" on {host}" if host != socket.gethostname() else "")


def _read(descriptor: int) -> dict[str, Any]:
    os.lseek(descriptor, 0, os.SEEK_SET)
    try:
        content = json.loads(os.read(descriptor, LENGTH).decode())
    except (OSError, ValueError):
        return {}
    return content if isinstance(content, dict) else {}


def _write(descriptor: int, content: dict[str, Any]) -> None:
    os.lseek(descriptor, 0, os.SEEK_SET)
    os.write(descriptor, json.dumps(content).ljust(LENGTH - 1).encode() + b"\n")


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        # A byte beyond the text, so that the holder's name stays readable.
        os.lseek(descriptor, 1000, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        os.lseek(descriptor, 0, os.SEEK_SET)

else:
    import fcntl

    def _lock(descriptor: int) -> None:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
