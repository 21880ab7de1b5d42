"""A Dask scheduler and its workers, all real processes of their own."""

import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest
from inline_pool import InlinePool
from small_build import quiet
from tiny_capture import TINY, write_tiny_capture
from work_contents import contents

import unstructured_mg
from unstructured_mg.errors import UserError
from unstructured_mg.pipeline import build as build_module
from unstructured_mg.pipeline.build import build
from unstructured_mg.pipeline.cluster import ClusterPool, describe_worker
from unstructured_mg.pipeline.pool import SINGLE_THREAD
from unstructured_mg.pipeline.progress import StageProgress

pytest.importorskip("distributed", reason="pip install 'unstructured_mg[cluster]'")


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """The scheduler's address and two worker processes of one thread each."""
    folder = tmp_path_factory.mktemp("cluster")
    file = folder / "scheduler.json"
    source = str(Path(unstructured_mg.__file__).parents[1])
    environment = {**os.environ, **SINGLE_THREAD, "PYTHONPATH": source}
    common = {"cwd": folder, "env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    quick = ["--scheduler-file", file, "--no-dashboard"]
    command = [sys.executable, "-m", "dask", "scheduler", "--port", "0", "--host", "127.0.0.1", *quick]
    processes = [subprocess.Popen(command, **common)]
    worker = [sys.executable, "-m", "dask", "worker", "--nthreads", "1", "--no-nanny", *quick]
    processes += [subprocess.Popen([*worker, "--name", str(number)], **common) for number in range(2)]
    try:
        from distributed import Client

        deadline = time.monotonic() + 120
        while not file.exists():
            assert time.monotonic() < deadline and processes[0].poll() is None
            time.sleep(0.05)
        with Client(scheduler_file=str(file), set_as_default=False) as client:
            client.wait_for_workers(2, timeout=120)
            address = client.scheduler.address
        yield address, processes[1:]
    finally:
        for process in processes:
            process.kill()
            process.wait()


def test_workers_that_cannot_do_the_work_are_named(cluster, tmp_path):
    address, _ = cluster
    with ClusterPool(address) as pool:
        assert pool.workers == 2
        pool.check(tmp_path)
        assert pool.submit(describe_worker, str(tmp_path)).result()[1:] == (None, True)
        with pytest.raises(UserError, match="does not see .*nowhere"):
            pool.check(tmp_path / "nowhere")
        with pytest.raises(ZeroDivisionError):
            pool.submit(divmod, 1, 0).result()
        assert list(pool.executor.map(divmod, [7, 8], [2, 3])) == [(3, 1), (2, 2)]
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv(name, "8")
            assert describe_worker(str(tmp_path))[1:] == ((name, "8"), True)


def test_a_build_that_loses_a_worker_is_the_build_of_one_process(cluster, tmp_path, monkeypatch):
    address, workers = cluster
    capture = write_tiny_capture(tmp_path / "capture")

    class Killing(StageProgress):
        """Kills a worker when both have had a pair to track for a moment."""

        tracked = 0

        def why(self, name: str, reason: str) -> None:
            self.tracked += name.startswith("pairs/")
            if self.tracked == 2:
                threading.Timer(0.2, workers[0].send_signal, [signal.SIGKILL]).start()

    options = replace(TINY, max_pairs=2)
    build(capture, tmp_path / "cluster", options, 1, Killing(quiet()._console), address)
    assert workers[0].wait(60) == -signal.SIGKILL and workers[1].poll() is None
    monkeypatch.setattr(build_module, "open_pool", lambda workers, address: InlinePool())
    build(capture, tmp_path / "alone", options, 1, quiet())
    assert contents(tmp_path / "cluster") == contents(tmp_path / "alone")


def test_where_no_scheduler_answers_nothing_is_left_behind(tmp_path, monkeypatch):
    monkeypatch.setattr("unstructured_mg.pipeline.cluster.PATIENCE", 0.5)
    capture = write_tiny_capture(tmp_path / "capture", 3)
    with pytest.raises(UserError, match="tcp://127.0.0.1:9: there is no Dask scheduler that answers"):
        build(capture, tmp_path / "work", TINY, 1, quiet(), "tcp://127.0.0.1:9")
    assert not (tmp_path / "work").exists()
