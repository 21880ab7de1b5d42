import errno
import json
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline import lock
from unstructured_mg.pipeline.lock import FolderLock, lock_holder

HOLD = """
import sys, time
from pathlib import Path
from unstructured_mg.pipeline.lock import FolderLock
with FolderLock(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(100)
"""


def test_a_second_writer_is_turned_away_and_told_who_holds_it(tmp_path):
    assert lock_holder(tmp_path) is None
    with FolderLock(tmp_path):
        with pytest.raises(UserError, match=rf"another umg \(process {os.getpid()}\)"):
            FolderLock(tmp_path).__enter__()
        assert lock_holder(tmp_path) == f"process {os.getpid()}"
    assert lock_holder(tmp_path) is None
    with FolderLock(tmp_path):
        pass
    assert (tmp_path / "lock").read_bytes() == b""


def test_the_lock_of_a_killed_process_is_free(tmp_path):
    holder = subprocess.Popen([sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    try:
        assert holder.stdout.readline() == "held\n"
        with pytest.raises(UserError, match=f"process {holder.pid}"):
            FolderLock(tmp_path).__enter__()
    finally:
        holder.send_signal(signal.SIGKILL)
        holder.wait()
        holder.stdout.close()
    # On the machine that it died on nobody has to wait.
    with FolderLock(tmp_path, patience=1000):
        assert json.loads((tmp_path / "lock").read_text())["process"] == os.getpid()


def elsewhere(count):
    """What a holder on another machine writes, whose system lock is not seen here."""
    content = {"process": 7, "host": "render-3", "machine": "render-3 5f1c", "count": count}
    return json.dumps(content).ljust(lock.LENGTH - 1) + "\n"


def test_another_machine_that_goes_on_counting_is_waited_for_and_a_dead_one_is_not(tmp_path):
    path = tmp_path / "lock"
    path.write_text(elsewhere(3))
    counting = threading.Timer(0.2, lambda: path.write_text(elsewhere(4)))
    counting.start()
    with pytest.raises(UserError, match=r"process 7 on render-3"):
        FolderLock(tmp_path, patience=20).__enter__()
    counting.join()
    assert path.read_text() == elsewhere(4)
    began = time.monotonic()
    with FolderLock(tmp_path, patience=0.3) as held:
        assert time.monotonic() - began >= 0.3
        held.check()


def test_a_disk_without_locks_is_used_by_counting_alone(tmp_path, monkeypatch):
    def unknown(descriptor):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(lock, "_lock", unknown)
    with FolderLock(tmp_path, beat=0.02):
        with pytest.raises(UserError, match="another umg"):
            FolderLock(tmp_path, patience=20).__enter__()
    with FolderLock(tmp_path, patience=1000):
        pass


def test_a_holder_counts_and_notices_when_it_was_taken_for_dead(tmp_path):
    path = tmp_path / "lock"
    with FolderLock(tmp_path, beat=0.02) as held:
        deadline = time.monotonic() + 20
        while json.loads(path.read_text())["count"] < 3:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        held.check()
        path.write_text(elsewhere(0))
        while not held._lost:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        with pytest.raises(UserError, match="another machine took this folder over"):
            held.check()
    # The other's mark stays.
    assert path.read_text() == elsewhere(0)


@pytest.mark.parametrize("content", [b"", b"4711", b"\xff\xfe", b"[]", b"{", b'{"host": 3}' * 100])
def test_a_mark_that_makes_no_sense_is_no_holder(tmp_path, content):
    (tmp_path / "lock").write_bytes(content)
    with FolderLock(tmp_path, patience=1000):
        pass
