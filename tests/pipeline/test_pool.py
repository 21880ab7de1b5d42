import os
import signal
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool

import pytest

from unstructured_mg.pipeline.pool import SINGLE_THREAD, Pool


def thread_variables():
    return {name: os.environ.get(name) for name in SINGLE_THREAD}


def test_workers_have_one_blas_thread_and_a_dead_one_can_be_replaced():
    with Pool(1) as pool:
        assert pool.submit(thread_variables).result() == SINGLE_THREAD
        broken = pool.submit(os._exit, 3)
        assert broken.exception() is not None
        assert isinstance(pool.submit(os.getpid).exception(), BrokenProcessPool)
        pool.restart()
        assert pool.submit(os.getpid).result() != os.getpid()


def test_workers_end_when_their_parent_is_killed():
    script = "\n".join(
        [
            "import os, time",
            "from unstructured_mg.pipeline.pool import Pool",
            "if __name__ == '__main__':",
            "    pool = Pool(1)",
            "    print(pool.submit(os.getpid).result(), flush=True)",
            "    time.sleep(100)",
        ]
    )
    parent = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    worker = int(parent.stdout.readline())
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    parent.stdout.close()
    for _ in range(100):
        try:
            os.kill(worker, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    os.kill(worker, signal.SIGKILL)
    raise AssertionError("the worker outlived its parent by ten seconds")


def test_a_killed_pool_leaves_no_worker_and_waits_for_none():
    started = time.perf_counter()
    pool = Pool(1)
    worker = pool.submit(os.getpid).result()
    stuck = pool.submit(time.sleep, 100)
    pool.kill()
    assert stuck.cancelled() or stuck.exception() is not None
    assert time.perf_counter() - started < 60
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)


def test_workers_do_not_see_an_interrupt():
    """Ctrl-C goes to all processes of a terminal: here, to the group of a script and its worker, before the worker has
    even started."""
    script = "\n".join(
        [
            "import os, signal",
            "from unstructured_mg.pipeline.pool import Pool",
            "if __name__ == '__main__':",
            "    with Pool(1) as pool:",
            "        answer = pool.submit(os.getpid)",
            "        try:",
            "            os.killpg(0, signal.SIGINT)",
            "            answer.result()",
            "        except KeyboardInterrupt:",
            "            print(answer.result() > 0)",
        ]
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, start_new_session=True)
    assert (done.stdout, done.stderr, done.returncode) == ("True\n", "", 0)
