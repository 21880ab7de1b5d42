import os
import signal
import subprocess
import sys

import pytest

from unstructured_mg.errors import UserError
from unstructured_mg.pipeline.lock import FolderLock

HOLD = """
import sys, time
from pathlib import Path
from unstructured_mg.pipeline.lock import FolderLock
with FolderLock(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(100)
"""


def test_a_second_writer_is_turned_away_and_told_who_holds_it(tmp_path):
    with FolderLock(tmp_path):
        with pytest.raises(UserError, match=rf"another umg \(process {os.getpid()}\)"):
            FolderLock(tmp_path).__enter__()
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
    with FolderLock(tmp_path):
        assert (tmp_path / "lock").read_text() == str(os.getpid())
